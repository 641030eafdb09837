// The controller's end of the link (protocol/README.md): sessions, lease, refusals, states. One thread; talks to the
// cycle through the mailboxes alone. No message of a peer, whatever it holds, can end the program or move the arm
// without handshake, lease and limits; Stop is taken from everybody, always.
#pragma once

#include <algorithm>
#include <deque>
#include <memory>
#include <vector>

#include "arm_controller/file_writer.hpp"
#include "arm_controller/link_orders.hpp"
#include "arm_controller/link_session.hpp"
#include "arm_controller/messages.hpp"
#include "arm_controller/statistics.hpp"

namespace armsight::arm {

class LinkServer {
 public:
  /// Listens at "ADDR:PORT"; throws std::runtime_error with the reason.
  LinkServer(const std::string& address, const RobotConfig& robot, const std::string& bus, Mailboxes& mailboxes,
             const LoopStatistics& statistics, FileWriter& files, net::Clock& clock);

  /// Receives, judges, hands on: Stops first, and of each peer only so much that nobody waits behind a flood.
  void step(Time now);
  /// Sends what the cycle said, and the state every 20 ms.
  void publish(Time now);
  /// Says goodbye to everybody.
  void close(Time now);

  std::uint16_t port() const { return server_.port(); }
  std::vector<int> descriptors() const { return server_.descriptors(); }
  Mode mode() const { return state_.mode; }

 private:
  struct Message {
    LinkSession& peer;
    const wire::Envelope& envelope;
    Time arrival, now;
    bool is_before_stop = false;  ///< a Stop came behind it in the same step, and was taken first
    Tag tag() const { return {peer.session, envelope.sequence()}; }
  };

  LinkSession& session_of(net::FramedStream* stream);
  void forget(net::FramedStream* stream);
  void handle(LinkSession& peer, const std::optional<wire::Envelope>& envelope, Time arrival, Time now, bool is_before_stop);
  void on_stop(const Message& m);
  bool check_order_of_messages(const Message& m);
  void dispatch(const Message& m);
  void on_hello(const Message& m);
  void on_heartbeat(const Message& m);
  void on_lease(const Message& m);
  void on_black_box(const Message& m);
  void on_command(const Message& m);
  template <typename Order, typename Body, typename... View>
  void hand_on(const Message& m, Slot<Order>& slot, const Body& body, const View&... view);
  bool is_expired(const Message& m, std::int64_t valid_for_ns);
  void keep_pose_goal(const Message& m);
  void judge_pose_goal(Time now);
  void drop_pose_goal(const Refused& why, Time now);
  void on_look(const Message& m);

  void renew_lease(const Message& m);
  void end_lease(FaultCode why, Time now);
  void post_lease();

  void send(LinkSession& peer, wire::Envelope& envelope, Time now);
  void accept(const Message& m);
  void refuse(const Message& m, const Refused& why);
  void protocol_error(LinkSession& peer, std::uint64_t sequence, const Refused& why, Time now);
  void send_refusal(LinkSession& peer, std::uint64_t sequence, const Refused& why, Time now);
  void send_refusal(const Tag& tag, const Refused& why, Time now);
  void broadcast(wire::Envelope& envelope, Time now);
  void take_events(Time now);
  void publish_event(const Event& event, Time now);
  void publish_answer(const AnswerEvent& answer, Time now);
  void hold_or_tell(const Event& event, Time now);
  void tell(const Event& event, Time now);
  void tell_saved(Time now);
  void watch_saving(Time now);
  std::uint64_t revision_on_disk() const { return std::max(loaded_revision_, files_.saved_revision()); }
  void publish_state(Time now);
  void publish_statistics(Time now);
  void tell_self_check(const SelfCheck& check);
  void greet(LinkSession& peer, Time now);
  LinkView view() const { return {robot_, state_}; }

  RobotConfig robot_;
  std::uint64_t model_hash_;
  std::string bus_;
  Mailboxes& mailboxes_;
  const LoopStatistics& statistics_;
  FileWriter& files_;
  net::Clock& clock_;
  net::StreamServer server_;
  std::vector<std::unique_ptr<LinkSession>> sessions_;
  std::uint64_t next_session_ = 0, protocol_errors_ = 0;
  Duration lease_length_;
  Lease lease_;                       ///< session 0: free
  struct PoseGoalInHand {
    std::uint64_t session;
    wire::Envelope envelope;
    Time arrival;
  };
  std::optional<PoseGoalInHand> pose_goal_;  ///< the newest, judged when all else of this step is done
  ArmSnapshot state_;
  std::uint64_t loaded_revision_ = 0;
  std::optional<ModelEvent> unsaved_; ///< the newest that was given to the disk and is not there yet
  std::deque<Event> held_;            ///< what names a revision that is not on disk yet, and what came after it
  std::optional<ModelEvent> model_;   ///< last published
  std::optional<FaultEvent> fault_;
  std::optional<StopEvent> stop_;
  std::vector<CheckLine> short_of_;   ///< of the last self-check: degraded or refused
  Time next_state_{}, next_statistics_{};
  std::optional<Time> save_again_at_;
};

}  // namespace armsight::arm
