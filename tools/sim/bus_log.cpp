#include "tools/sim/bus_log.hpp"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace armsight::sim {

namespace {

constexpr auto kPause = std::chrono::milliseconds(20);

}  // namespace

BusLog::BusLog(const std::filesystem::path& file) : path_(file), file_(file) {
  if (!file_) throw std::runtime_error(file.string() + ": cannot be written: " + std::strerror(errno));
  writer_ = std::jthread([this](const std::stop_token& stop) { write_until_stopped(stop); });
}

BusLog::~BusLog() {
  try {
    flush();
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "arm_sim: %s\n", error.what());
  }
}

void BusLog::add(CandumpLine record) {
  newest_.push_back(std::move(record));
  const std::unique_lock lock(mutex_, std::try_to_lock);
  if (!lock) return;
  handed_over_.insert(handed_over_.end(), newest_.begin(), newest_.end());
  newest_.clear();
}

void BusLog::flush() {
  std::unique_lock lock(mutex_);
  handed_over_.insert(handed_over_.end(), newest_.begin(), newest_.end());
  newest_.clear();
  is_flushing_ = true;
  wake_.notify_one();
  is_written_.wait(lock, [this] { return handed_over_.empty() && !is_writing_; });
  is_flushing_ = false;
  if (!file_) throw std::runtime_error(path_.string() + ": cannot be written any more; frames are missing at its end");
}

void BusLog::write_until_stopped(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    wake_.wait_for(lock, stop, kPause, [this] { return is_flushing_ && !handed_over_.empty(); });
    if (handed_over_.empty()) continue;
    const std::vector<CandumpLine> records = std::exchange(handed_over_, {});
    is_writing_ = true;
    lock.unlock();
    write(records);
    lock.lock();
    is_writing_ = false;
    is_written_.notify_all();
  }
}

void BusLog::write(const std::vector<CandumpLine>& records) {
  for (const CandumpLine& record : records) file_ << to_candump(record) << '\n';
  file_.flush();
}

}  // namespace armsight::sim
