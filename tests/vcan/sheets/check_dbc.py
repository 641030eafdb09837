"""check_dbc.py DBC WIRE: canmatrix decodes the frames that our code encoded (WIRE, of dump_wire) to the same values."""
import sys

import canmatrix.formats

matrix = canmatrix.formats.loadp_flat(sys.argv[1])
count = 0
for line in open(sys.argv[2], encoding="ascii"):
    if not line.startswith("frame "):
        continue
    _, name, identifier, data, *signals = line.split()
    frame = matrix.frame_by_name(name)
    assert frame is not None, f"{name}: not in the DBC"
    assert frame.arbitration_id.id == int(identifier, 16), f"{name}: {frame.arbitration_id.id:X} in the DBC, {identifier} in code"
    assert frame.size == len(data) // 2, f"{name}: {frame.size} bytes in the DBC, {len(data) // 2} in code"
    decoded = {key: int(signal.raw_value) for key, signal in frame.decode(bytes.fromhex(data)).items()}
    wanted = {key: int(value) for key, value in (signal.split("=") for signal in signals)}
    assert decoded == wanted, f"{name}: {decoded} by the DBC, {wanted} by the code"
    count += 1
assert count > 0, "no frames to compare"
assert len(matrix.frames) == 3 + 6 * 6, f"{len(matrix.frames)} messages in the DBC"
print(f"check_dbc: {count} kinds of frames decoded by canmatrix as encoded by us")
