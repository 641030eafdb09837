// The simulated camera on TCP (protocol/camera_stream.proto): pixels, stamps and nominal intrinsics, nothing else.
// Exposures lie on a grid of simulated time; one is drawn and sent only if a client asked for it. It is sent when its
// seeded latency is over, stamped with its middle in the client's own clock.
//
//   lockstep: arm_sim calls advance() once a cycle        real pace: a thread of arm_sim calls it, every few ms
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>

#include "protocol/transport/framed_stream.hpp"
#include "tools/sim/renderer.hpp"

namespace armsight::sim {

class CameraServer {
 public:
  /// Listens at "ADDR:PORT"; port 0: the system chooses.
  CameraServer(const std::string& address, net::Clock& clock, const Scene& scene, const MarkerConfig& hand_marker,
               const NoiseFigures& noise, std::uint64_t seed, ToOwnClock to_own_clock);

  std::uint16_t port() const { return server_.port(); }
  /// Takes requests, decides the exposures that began up to `sim_time_ns`, draws those that ended, sends those due.
  void advance(std::int64_t sim_time_ns, const WorldAt& world_at);
  std::uint64_t rendered() const { return rendered_; }
  std::vector<int> descriptors() const { return server_.descriptors(); }

 private:
  struct Client {
    std::uint32_t participant = 0;
    std::uint32_t wanted = 0;  ///< exposures still to be taken
  };
  struct Exposure {
    std::uint64_t number = 0;
    std::int64_t middle_ns = 0, end_ns = 0, send_ns = 0;
    std::vector<net::FramedStream*> takers;
    cv::Mat picture;           ///< empty until drawn
  };

  void take_messages();
  void answer(net::FramedStream& stream, Client& client, const std::string& payload);
  void begin_exposures(std::int64_t now_ns);
  void draw(Exposure& exposure, const WorldAt& world_at);
  void send(const Exposure& exposure);

  CameraOptics optics_;
  std::uint64_t seed_;
  ToOwnClock to_own_clock_;
  net::StreamServer server_;
  Renderer renderer_;
  std::map<net::FramedStream*, Client> clients_;
  std::deque<Exposure> exposures_;
  std::uint64_t next_number_ = 0;
  std::uint64_t rendered_ = 0;
};

}  // namespace armsight::sim
