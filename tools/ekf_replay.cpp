// ekf_replay: a recording's looks through the filter of this build, held against the golden table beside the recording
// (golden/NAME.csv). Exit codes: 0 as golden or written, 1 different, 2 bad flag, file or recording.
#include <cstdio>
#include <fstream>
#include <sstream>

#include "protocol/config.hpp"
#include "tools/command_line.hpp"
#include "tools/replay/filter_replay.hpp"

namespace {

using namespace armsight;
namespace fs = std::filesystem;

struct Flags {
  std::string file, golden, robot, extract;
  bool update = false;
};

int fail(int code, const std::string& what) {
  std::fprintf(stderr, "ekf_replay: %s\n", what.c_str());
  return code;
}

RobotConfig robot_of(const Flags& flags, const replay::LinkFile& file) {
  if (!flags.robot.empty()) return load_robot(flags.robot);
  if (!file.info || file.info->configuration().empty())
    throw ConfigError(flags.file + ": does not name its robot (a recording of link_record): give --robot FILE");
  return parse_robot(file.info->configuration(), flags.file + "/info");
}

fs::path golden_of(const Flags& flags) {
  if (!flags.golden.empty()) return flags.golden;
  const fs::path file = flags.file;
  return file.parent_path() / "golden" / (file.stem().string() + ".csv");
}

/// What the filter needs of a long recording, as a small one.
void extract(const replay::LinkFile& file, const RobotConfig& robot, const std::string& path) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!out) throw ConfigError("--extract " + path + ": cannot be written");
  RecordingWriter writer(out, {"ekf_replay"});
  const ChannelId info_channel = writer.add_channel("/info", "armsight.wire.RecordingInfo");
  const ChannelId link = writer.add_channel("/link", "armsight.wire.LinkRecord");
  wire::RecordingInfo info = file.info.value_or(wire::RecordingInfo());
  info.set_robot(robot.robot);
  writer.write(info_channel, time_from_ns(info.time_ns()), info.SerializeAsString());
  for (const wire::LinkRecord& record : file.messages)
    if (replay::is_of_the_filter(record))
      writer.write(link, time_from_ns(record.time_ns()), record.SerializeAsString());
  writer.close();
  if (!writer.is_good()) throw ConfigError("--extract " + path + ": writing failed");
}

void write_golden(const fs::path& path, const std::string& csv) {
  if (!path.parent_path().empty()) fs::create_directories(path.parent_path());
  std::ofstream out(path, std::ios::trunc);
  out << csv << std::flush;
  if (!out) throw ConfigError(path.string() + ": cannot be written");
}

int run(const Flags& flags) {
  const replay::LinkFile file = replay::load_link_file(flags.file);
  const RobotConfig robot = robot_of(flags, file);
  if (!flags.extract.empty()) {
    extract(file, robot, flags.extract);
    return 0;
  }
  const std::vector<replay::FilterStep> steps = replay::replay_filter(file, robot);
  const std::string csv = replay::to_csv(steps);
  const fs::path golden = golden_of(flags);
  if (flags.update) {
    write_golden(golden, csv);
    std::printf("ekf_replay: %zu looks written to %s\n", steps.size(), golden.c_str());
    return 0;
  }
  std::ifstream in(golden);
  std::stringstream text;
  text << in.rdbuf();
  if (!in) throw ConfigError(golden.string() + ": cannot be read; --update writes it");
  const std::string difference = replay::first_csv_difference(text.str(), csv);
  if (!difference.empty()) return fail(1, golden.string() + ": different: " + difference);
  std::printf("ekf_replay: %zu looks as in %s\n", steps.size(), golden.c_str());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  tools::CommandLine line("Puts a recording's looks through the filter and holds the result against the golden table.",
                          "ekf_replay");
  Flags flags;
  line.add("FILE", flags.file, "recording with the link of an adapt: STATE/ticks.mcap or link_record's").required();
  line.add("--golden", flags.golden, "the table; default golden/NAME.csv beside FILE");
  line.add("--update", flags.update, "write the table instead");
  line.add("--robot", flags.robot, "robot file, where the recording holds none");
  line.add("--extract", flags.extract, "write the filter's messages of FILE as a small recording, nothing else");
  if (const auto code = line.parse(argc, argv)) return *code;
  try {
    return run(flags);
  } catch (const RecordingError& error) {
    const std::string what = error.what();
    return fail(2, what.starts_with(flags.file) ? what : flags.file + ": " + what);
  } catch (const std::exception& error) {
    return fail(2, error.what());
  }
}
