#include "arm_controller/file_writer.hpp"

#include <sys/resource.h>

#include <condition_variable>
#include <cstdio>
#include <deque>
#include <mutex>
#include <optional>
#include <set>
#include <thread>
#include <vector>

#include "arm_controller/black_box.hpp"
#include "arm_controller/last_position.hpp"
#include "arm_controller/state_folder.hpp"
#include "arm_controller/tick_recording.hpp"

namespace armsight::arm {
namespace {

constexpr auto kPollPeriod = std::chrono::milliseconds(5);
constexpr std::uint64_t kTicksPerFlush = 250;
constexpr double kMovedAtAll_rad = 0.01;
constexpr std::size_t kMaxWaiting_bytes = 2 * 1024 * 1024;  // of the link: a disk that sleeps for a minute loses nothing

wire::RecordingInfo make_info(const RobotConfig& robot, const std::string& bus, const std::string& configuration) {
  wire::RecordingInfo info;
  info.set_program("arm_controller " ARMSIGHT_VERSION);
  info.set_robot(robot.robot);
  info.set_model_hash(model_hash(robot));
  info.set_rate_hz(1.0 / robot.controller.period_s);
  info.set_bus(bus);
  for (const std::string& name : robot.joint_names) info.add_joint_names(name);
  info.set_configuration(configuration);
  return info;
}

}  // namespace

struct FileWriter::Impl {
  Impl(const std::filesystem::path& folder_path, const RobotConfig& robot_config, const wire::RecordingInfo& recording_info,
       Tape& cycle_tape)
      : folder(folder_path), robot(robot_config), info(recording_info), tape(cycle_tape) {}

  void run();
  void drain_tape();
  void write_black_box(const FaultEvent& fault);
  void save_position();
  void save(const ModelEvent& model);
  void post(wire::LinkRecord record);
  void tell_broken(const std::string& sentence);

  std::filesystem::path folder;
  RobotConfig robot;
  wire::RecordingInfo info;
  Tape& tape;
  std::optional<TickRecording> recording;
  BlackBox last_ticks;
  std::uint64_t ticks_written = 0, cycle = 0;
  JointVector last_position, saved_position;  ///< size 0: none

  mutable std::mutex mutex;
  std::filesystem::path newest_black_box;
  std::condition_variable wake, done;
  std::vector<wire::LinkRecord> link_records;
  std::size_t waiting_bytes = 0;
  std::optional<ModelEvent> model;  ///< to be saved: the file holds one, so the newest is enough
  std::uint64_t requested = 0, completed = 0;
  bool leaves = false;
  std::atomic<std::uint64_t> saved_revision{0};
  StickyFlag save_failed;
  std::atomic<bool> recording_is_broken{false};
  std::atomic<std::uint64_t> link_records_lost{0};
  std::set<std::string> told_broken;
  std::string last_complaint;
  std::thread thread;
};

FileWriter::FileWriter(const std::filesystem::path& state_folder, const RobotConfig& robot, const std::string& bus,
                       const std::string& configuration, Tape& tape)
    : impl_(std::make_unique<Impl>(state_folder, robot, make_info(robot, bus, configuration), tape)) {}

void FileWriter::begin(Time now) {
  impl_->info.set_time_ns(to_ns(now));
  impl_->recording.emplace(new_recording_file(impl_->folder), impl_->info);
  impl_->thread = std::thread([this] { impl_->run(); });
}

FileWriter::~FileWriter() {
  if (!impl_->thread.joinable()) return;
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->leaves = true;
  }
  impl_->wake.notify_all();
  impl_->thread.join();
}

void FileWriter::Impl::run() {
  setpriority(PRIO_PROCESS, 0, 5);  // of this thread: after the cycle and the link
  for (bool is_last = false; !is_last;) {
    std::vector<wire::LinkRecord> records;
    std::optional<ModelEvent> to_save;
    std::uint64_t ticket = 0;
    {
      std::unique_lock lock(mutex);
      wake.wait_for(lock, kPollPeriod, [this] { return leaves || requested > completed || model || !link_records.empty(); });
      records.swap(link_records);
      waiting_bytes = 0;
      to_save.swap(model);
      ticket = requested;
      is_last = leaves;
    }
    drain_tape();
    if (to_save) save(*to_save);
    for (const wire::LinkRecord& record : records) recording->write(record);
    {
      const std::lock_guard lock(mutex);
      completed = ticket;
    }
    done.notify_all();
  }
  save_position();
}

void FileWriter::Impl::drain_tape() {
  TickRecord record;
  OrdersRecord orders;
  tape.checkpoints.take([this](std::uint64_t at_cycle, std::span<const std::byte> state) { last_ticks.keep_checkpoint(at_cycle, state); });
  while (tape.ticks.pop(record)) {
    while (tape.orders.pop(orders)) last_ticks.keep(orders);  // a tick's own were pushed before it
    cycle = record.cycle;
    recording->write(record);
    last_ticks.keep(record);
    if (record.state.has_positions) last_position = record.state.q_reading_rad;
    if (++ticks_written % kTicksPerFlush != 0) continue;
    recording->flush();
    save_position();
    if (!recording->is_good()) tell_broken((folder / "ticks.mcap").string() + ": cannot be written to its end (disk full?)");
  }
  Event event;
  while (tape.events.pop(event))
    if (const auto* fault = std::get_if<FaultEvent>(&event)) write_black_box(*fault);
}

void FileWriter::Impl::write_black_box(const FaultEvent& fault) {
  try {
    const std::filesystem::path file = new_black_box_file(folder, fault);
    last_ticks.write(file, info);
    std::fprintf(stderr, "arm_controller: fault %d (%s): %s; last %zu cycles in %s\n", static_cast<int>(fault.fault.code),
                 fault_side(fault.fault.code), fault_text(fault.fault).c_str(), last_ticks.size(), file.c_str());
    const std::lock_guard lock(mutex);
    newest_black_box = file;
  } catch (const std::exception& e) {
    recording_is_broken = true;
    std::fprintf(stderr, "arm_controller: black box: %s\n", e.what());
  }
}

// A disk that is full costs the comparison at the next start, no more.
void FileWriter::Impl::save_position() {
  const bool is_known = last_position.size() != 0;
  const bool has_moved = is_known && (saved_position.size() == 0 ||
                                      (last_position - saved_position).cwiseAbs().maxCoeff() > kMovedAtAll_rad);
  if (!has_moved) return;
  try {
    save_last_position(folder, robot, last_position);
    saved_position = last_position;
  } catch (const std::exception& e) {
    tell_broken(e.what());
  }
}

// A full disk ends a recording, not the arm; whoever relies on it must learn.
void FileWriter::Impl::tell_broken(const std::string& sentence) {
  recording_is_broken = true;
  if (told_broken.insert(sentence).second) std::fprintf(stderr, "arm_controller: %s\n", sentence.c_str());
}

void FileWriter::Impl::save(const ModelEvent& newest) {
  try {
    save_model_in_force(folder, robot, newest);
    saved_revision.store(newest.model.revision, std::memory_order_release);
    last_complaint.clear();
  } catch (const std::exception& e) {
    if (e.what() != last_complaint) std::fprintf(stderr, "arm_controller: %s\n", e.what());
    last_complaint = e.what();
    save_failed.set();
  }
}

// The link never waits for the disk: what finds no room is counted, and told in the statistics.
void FileWriter::Impl::post(wire::LinkRecord record) {
  const std::size_t bytes = sizeof record + record.ByteSizeLong();
  {
    const std::lock_guard lock(mutex);
    if (waiting_bytes + bytes > kMaxWaiting_bytes) {
      if (link_records_lost.fetch_add(1, std::memory_order_relaxed) == 0)
        std::fprintf(stderr, "arm_controller: ticks.mcap: the disk is too slow for the link, messages go unrecorded\n");
      return;
    }
    waiting_bytes += bytes;
    link_records.push_back(std::move(record));
  }
  wake.notify_one();
}

void FileWriter::save_model(const ModelEvent& model) {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->model = model;
  }
  impl_->wake.notify_one();
}

void FileWriter::record_link(bool to_controller, const std::string& peer, const wire::Envelope& envelope, Time now) {
  wire::LinkRecord record;
  record.set_to_controller(to_controller);
  record.set_peer(peer);
  *record.mutable_envelope() = envelope;
  record.set_time_ns(to_ns(now));
  impl_->post(std::move(record));
}

std::uint64_t FileWriter::saved_revision() const { return impl_->saved_revision.load(std::memory_order_acquire); }
std::filesystem::path FileWriter::newest_black_box() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->newest_black_box;
}
bool FileWriter::recording_is_broken() const { return impl_->recording_is_broken.load(std::memory_order_relaxed); }
std::uint64_t FileWriter::link_records_lost() const {
  return impl_->link_records_lost.load(std::memory_order_relaxed);
}
bool FileWriter::take_save_failure() { return impl_->save_failed.take(); }

void FileWriter::wait_idle() {
  std::unique_lock lock(impl_->mutex);
  const std::uint64_t ticket = ++impl_->requested;
  impl_->wake.notify_all();
  impl_->done.wait(lock, [&] { return impl_->completed >= ticket; });
}

}  // namespace armsight::arm
