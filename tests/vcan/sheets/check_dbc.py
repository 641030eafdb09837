"""check_dbc.py DBC WIRE: canmatrix decodes the frames that our code encoded (WIRE, of dump_wire) to the same values."""
import sys

import canmatrix.formats

matrix = canmatrix.formats.loadp_flat(sys.argv[1])
count = 0
physical_count = 0
for line in open(sys.argv[2], encoding="ascii"):
    if not line.startswith(("frame ", "physical ")):
        continue
    kind, name, identifier, data, *signals = line.split()
    frame = matrix.frame_by_name(name)
    assert frame is not None, f"{name}: not in the DBC"
    assert frame.arbitration_id.id == int(identifier, 16), f"{name}: {frame.arbitration_id.id:X} in the DBC, {identifier} in code"
    assert frame.size == len(data) // 2, f"{name}: {frame.size} bytes in the DBC, {len(data) // 2} in code"
    signals_in_frame = frame.decode(bytes.fromhex(data))
    if kind == "physical":
        wanted = {key: float(value) for key, value in (signal.split("=") for signal in signals)}
        decoded = {key: float(signal.phys_value) for key, signal in signals_in_frame.items()}
        assert decoded.keys() == wanted.keys(), f"{name}: {sorted(decoded)} by the DBC, {sorted(wanted)} by the code"
        for key, signal in signals_in_frame.items():
            step = float(signal.signal.factor)  # the codes' resolution: the value given is at most half of it away
            assert abs(decoded[key] - wanted[key]) <= 0.5001 * step, f"{name}.{key}: {decoded[key]} by the DBC, {wanted[key]} by the code"
        physical_count += 1
        continue
    decoded = {key: int(signal.raw_value) for key, signal in signals_in_frame.items()}
    wanted = {key: int(value) for key, value in (signal.split("=") for signal in signals)}
    assert decoded == wanted, f"{name}: {decoded} by the DBC, {wanted} by the code"
    count += 1
assert count > 0 and physical_count > 0, "no frames to compare"
assert len(matrix.frames) == 3 + 6 * 6 + 2 * 5 + 1, f"{len(matrix.frames)} messages in the DBC"
print(f"check_dbc: {count + physical_count} kinds of frames decoded by canmatrix as encoded by us")
