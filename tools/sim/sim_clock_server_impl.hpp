// Inside of SimClockServer: the participants, and what is on its way between them. Two files share it, who takes part
// (sim_clock_server.cpp) and what a cycle hands on (sim_clock_grants.cpp).
#pragma once

#include <map>
#include <mutex>

#include "protocol/sim_clock.pb.h"
#include "protocol/transport/framed_stream.hpp"
#include "tools/sim/sim_clock_server.hpp"

namespace armsight::sim {

using net::ChannelKey;
using net::ChannelKind;
using ChannelTotals = std::map<ChannelKey, std::uint64_t>;

enum class ParticipantPhase { kJoined, kWorking, kDone, kLeaving };

struct Participant {
  std::unique_ptr<net::FramedStream> stream;
  std::uint32_t id = 0;              ///< 0: has not said Join yet
  wire::SimRole role = wire::SIM_ROLE_UNSPECIFIED;
  std::string name;
  net::Crystal crystal;
  ParticipantPhase phase = ParticipantPhase::kJoined;
  ChannelTotals sent;                       ///< as reported with Done, since joining
  ChannelTotals handed_on;                  ///< of these, what became due somewhere
};

struct SimClockServer::Impl {
  SimClockOptions options;
  Wishes wishes;
  ServerClock clock;
  net::MonotonicClock stream_clock{net::Crystal{}, std::chrono::milliseconds(1)};
  std::unique_ptr<net::Listener> listener;
  std::vector<Participant> participants;
  std::uint32_t last_id = 0;
  std::uint32_t last_controller = 0;
  std::uint64_t cycle = 0;
  bool is_finished = false;
  std::map<std::uint32_t, std::map<ChannelKey, std::vector<Time>>> next_arrivals;  ///< receiver → (kind, sender) → when
  mutable std::mutex crystals_mutex;
  std::map<std::uint32_t, net::Crystal> crystals;  ///< also of those that left: late frames are still theirs

  Impl(const SimClockOptions& o, Wishes w)
      : options(o), wishes(std::move(w)), clock(o.is_lockstep), listener(net::listen_unix(o.path)) {
    clock.set_now(time_from_ns(kFirstTime_ns));
  }

  void serve();
  void handle(Participant& from, const std::string& payload);
  void welcome(Participant& joiner, const wire::Join& join);
  void take_totals(Participant& from, const wire::Done& done);
  void answer(Participant& to, const std::string& error);
  void drop_closed();
  void grant_all();
  void grant(Participant& to);
  void hand_on();
  void hand_on_from(Participant& sender);
  std::uint32_t controller() const;
  std::size_t joined() const;
  bool all_are(std::initializer_list<ParticipantPhase> phases) const;
  std::vector<int> descriptors() const;
};

}  // namespace armsight::sim
