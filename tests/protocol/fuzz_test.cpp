// Seeded mutations of good inputs through every entry point; ARMSIGHT_FUZZ_RUNS=N asks for more of them.
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <random>

#include "protocol/arm_link.pb.h"
#include "protocol/framing.hpp"
#include "protocol/strict_yaml.hpp"
#include "sample_recording.hpp"

extern "C" {
int fuzz_framing(const std::uint8_t* data, std::size_t size);
int fuzz_config(const std::uint8_t* data, std::size_t size);
int fuzz_candump(const std::uint8_t* data, std::size_t size);
int fuzz_recording(const std::uint8_t* data, std::size_t size);
}

namespace armsight {
namespace {

using Entry = int (*)(const std::uint8_t*, std::size_t);

std::size_t runs(std::size_t usual) {
  const char* wanted = std::getenv("ARMSIGHT_FUZZ_RUNS");
  return wanted == nullptr ? usual : std::strtoul(wanted, nullptr, 10);
}

class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}
  std::string operator()(std::string bytes) {
    for (std::size_t n = 1 + below(4); n > 0; --n) mutate(bytes);
    return bytes;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }
  char any_byte() { return static_cast<char>(random_() & 0xFF); }
  void mutate(std::string& bytes) {
    const std::size_t at = below(bytes.size());
    switch (below(7)) {
      case 0: bytes.insert(at, 1, any_byte()); break;
      case 1: bytes.erase(at, 1 + below(16)); break;
      case 2: bytes.resize(at); break;
      case 3: bytes.insert(at, bytes.substr(below(bytes.size()), below(64))); break;
      case 4:
        for (std::size_t i = 0; i < 8 && at + i < bytes.size(); ++i) bytes[at + i] = below(2) == 0 ? '\xFF' : '\0';
        break;
      default:
        if (!bytes.empty()) bytes[at] = below(2) == 0 ? any_byte() : static_cast<char>(bytes[at] ^ (1 << below(8)));
    }
  }
  std::mt19937 random_;
};

void run(Entry entry, const std::vector<std::string>& corpus, std::size_t count, std::uint32_t seed) {
  const google::protobuf::LogSilencer silent;  // it would tell every broken text on stderr
  Mutator mutate(seed);
  const auto call = [&](const std::string& bytes) {
    EXPECT_EQ(entry(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()), 0);
  };
  call("");
  for (const std::string& good : corpus) call(good);
  for (std::size_t i = 0; i < count; ++i) call(mutate(corpus[i % corpus.size()]));
}

std::string frame_of(const std::function<void(wire::Envelope&)>& fill) {
  wire::Envelope envelope;
  envelope.set_protocol_version(100);
  envelope.set_sequence(7);
  fill(envelope);
  return wire::encode_frame(wire::FrameType::kLink, envelope.SerializeAsString());
}

TEST(Fuzz, FramingAndEnvelope) {
  std::vector<std::string> corpus = {
      frame_of([](auto& e) { for (int i = 0; i < 5; ++i) e.mutable_joint_goal()->add_q_real_rad(0.1 * i); }),
      frame_of([](auto& e) { e.mutable_pose_goal()->mutable_hand_goal()->set_qw(1); }),
      frame_of([](auto& e) { for (int i = 0; i < 36; ++i) e.mutable_hand_pose()->add_covariance(i % 7 == 0); }),
      frame_of([](auto& e) { e.mutable_hello()->set_program("host 0.1.0"); })};
  corpus.push_back(corpus[0] + corpus[1] + corpus[2]);
  run(fuzz_framing, corpus, runs(20000), 1);
}

TEST(Fuzz, RobotAndModelFiles) {
  const std::string model =
      "format_version: 1\nrobot: ego_right_arm\nmodel_hash: 0x7d276dfa309ffa1b\nrevision: 3\nsource: a\n"
      "T_C_B: {position_m: [0, 0, 0], quaternion_wxyz: [1, 0, 0, 0]}\nbeta_rad: [0, 0]\n";
  run(fuzz_config, {read_text_file(ARMSIGHT_ROBOT_FILE), model}, runs(1500), 2);
}

TEST(Fuzz, Candump) {
  run(fuzz_candump, {"(1436509052.249713) can0 044#2A366C2BBA", "(1.000000) can0 20000040#0000000000000000",
                     "(1.000000) c 583#4B41600037120000"}, runs(20000), 3);
}

TEST(Fuzz, Recording) {
  std::ostringstream out;
  RecordingWriter writer(out, {"t", 300});
  for (int i = 0; i < 30; ++i)
    writer.write(i == 0 ? writer.add_channel("/can", "armsight.wire.CanRecord") : ChannelId{0}, time_from_ns(i),
                 "data");
  writer.close();
  run(fuzz_recording, {out.str()}, runs(5000), 4);
}

}  // namespace
}  // namespace armsight
