// Every frame of the bus as candump -L text in a file. The bus hands frames over without ever waiting; a thread of the
// log's own formats and writes them, because a disk may take tens of milliseconds.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>
#include <vector>

#include "protocol/candump.hpp"

namespace armsight::sim {

class BusLog {
 public:
  /// Throws std::runtime_error when the file cannot be written.
  explicit BusLog(const std::filesystem::path& file);
  /// Writes what is left.
  ~BusLog();

  /// One thread only, in order of time.
  void add(CandumpLine record);
  /// Returns when everything added so far is in the file, or throws std::runtime_error. From the thread that adds.
  void flush();

 private:
  void write_until_stopped(const std::stop_token& stop);
  void write(const std::vector<CandumpLine>& records);

  std::filesystem::path path_;
  std::ofstream file_;
  std::vector<CandumpLine> newest_;   ///< of the adding thread: not handed over yet
  std::mutex mutex_;
  std::condition_variable_any wake_, is_written_;
  std::vector<CandumpLine> handed_over_;
  bool is_flushing_ = false, is_writing_ = false;
  std::jthread writer_;
};

}  // namespace armsight::sim
