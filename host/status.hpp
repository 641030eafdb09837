// What `host status` shows: who the controller is, what it is doing, how well it keeps time. Needs no lease.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "host/host_io.hpp"

namespace armsight::host {

/// Prints it; with a file, the controller's statistics go there too, as JSON (host/README.md).
void run_status(HostIo& io, const std::filesystem::path& json_file, std::ostream& out);
/// One line whenever mode, fault, lease or model change, for so long (0: until interrupted). Lost links are made again,
/// once a second; nothing is commanded by it.
void run_watch(HostIo& io, double watch_s, std::ostream& out);

/// "wake-up late", "TPDO1 of node 3"; tables and figures of people call a row so.
std::string duration_name(const wire::DurationHistogram& row);
/// One line a row: p50, p99.9, longest, in microseconds.
std::string duration_table(const wire::ControllerStatistics& statistics);

}  // namespace armsight::host
