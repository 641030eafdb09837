#!/usr/bin/env python3
"""Commands an arm controller over its link: hello, lease, power, a goal, a stop. Written from protocol/README.md alone.

    protoc -I . --python_out=/tmp/as protocol/arm_link.proto        # in the project's folder
    PYTHONPATH=/tmp/as protocol/examples/arm_client.py 127.0.0.1:40002 0.1      # turns every joint by 0.1 rad

Needs python3-protobuf. Exit code: 0 stopped as asked; 1 refused; 3 link lost. """
import socket
import struct
import sys
import time

from protocol import arm_link_pb2 as wire

HEADER = struct.Struct("<HBBI")  # magic "AS", major version 1, type 1 = link, length
VERSION = 100  # 100 * major + minor


class Link:
    def __init__(self, address, role, model_hash=0):
        self.socket = socket.create_connection(tuple(address.rsplit(":", 1)), timeout=1.0)
        self.sequence, self.session, self.buffer, self.state = 0, 0, b"", None  # state: the newest ArmState
        self.send(hello=wire.Hello(protocol_version=VERSION, program="arm_client", role=role, model_hash=model_hash))
        self.reply = self.wait("hello_reply")
        self.session = self.reply.session

    def send(self, **body):
        self.sequence += 1
        envelope = wire.Envelope(protocol_version=VERSION, sequence=self.sequence, session=self.session,
                                 sent_time_ns=time.monotonic_ns(), **body)
        payload = envelope.SerializeToString()
        self.socket.sendall(HEADER.pack(0x5341, 1, 1, len(payload)) + payload)
        return self.sequence

    def receive(self, timeout_s=0.04):
        """The next envelope, or None after a while; a refusal ends the program with its reason."""
        self.socket.settimeout(timeout_s)
        while len(self.buffer) < HEADER.size or len(self.buffer) < HEADER.size + HEADER.unpack_from(self.buffer)[3]:
            try:
                data = self.socket.recv(65536)
            except socket.timeout:
                return None
            if not data:
                raise ConnectionError("the controller closed the connection")
            self.buffer += data
        end = HEADER.size + HEADER.unpack_from(self.buffer)[3]
        envelope = wire.Envelope.FromString(self.buffer[HEADER.size:end])
        self.buffer = self.buffer[end:]
        if envelope.HasField("refusal"):
            sys.exit(f"refused: {wire.RefusalReason.Name(envelope.refusal.reason)}: {envelope.refusal.text}")
        if envelope.HasField("stop_report"):
            print("stop {0.code} ({0.side}): {0.text}".format(envelope.stop_report))
        if envelope.HasField("arm_state"):
            self.state = envelope.arm_state
        return envelope

    def wait(self, body, is_it=lambda message: True, at_most_s=20.0):
        """Beats every 40 ms, so that the lease (200 ms) is kept, until the wanted message comes."""
        end, next_beat = time.monotonic() + at_most_s, 0.0
        while time.monotonic() < end:
            if self.session and time.monotonic() >= next_beat:
                self.send(heartbeat=wire.Heartbeat(host_send_time_ns=time.monotonic_ns()))
                next_beat = time.monotonic() + 0.04
            envelope = self.receive()
            if envelope and envelope.HasField(body) and is_it(getattr(envelope, body)):
                return getattr(envelope, body)
        raise ConnectionError(f"no {body} came within {at_most_s} s")


def main(address, turn_rad):
    # A commander proves with the hash that it means the same arm; knowing none, we take the controller's word for it.
    model_hash = Link(address, wire.ROLE_OBSERVE).reply.model_hash
    arm = Link(address, wire.ROLE_COMMAND, model_hash)
    print(f"{arm.reply.robot}: {arm.reply.joint_count} joints at {arm.reply.rate_hz:.0f} Hz on {arm.reply.bus}")
    lease = arm.send(lease_request=wire.LeaseRequest())
    arm.wait("accepted", lambda answer: answer.accepted_sequence == lease)
    arm.wait("arm_state", lambda state: state.mode in (wire.MODE_READY, wire.MODE_HOLD))
    arm.send(mode_request=wire.ModeRequest(mode=wire.MODE_HOLD))
    arm.wait("arm_state", lambda state: state.mode == wire.MODE_HOLD)
    start = list(arm.state.q_reading_rad)
    arm.send(joint_goal=wire.JointGoal(goal=1, q_real_rad=[q + turn_rad for q in start], speed_scale=0.5,
                                       valid_for_ns=500_000_000))
    arm.wait("goal_status", lambda status: status.state == wire.GOAL_STATE_MOVING)
    arm.wait("arm_state", lambda state: abs(state.q_reading_rad[0] - start[0]) > abs(turn_rad) / 4)
    arm.send(stop=wire.Stop(reason="arm_client: far enough"))
    arm.wait("goal_status", lambda status: status.state == wire.GOAL_STATE_STOPPED)
    arm.wait("arm_state", lambda state: state.mode == wire.MODE_HOLD and state.is_still)
    print("stopped after", " ".join(f"{q - q0:+.3f}" for q, q0 in zip(arm.state.q_reading_rad, start)), "rad")
    arm.send(bye=wire.Bye())


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        main(sys.argv[1], float(sys.argv[2]))
    except OSError as error:
        print(f"arm_client: {error}", file=sys.stderr)
        sys.exit(3)
