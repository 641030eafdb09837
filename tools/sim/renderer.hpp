// What the simulated camera sees: the world's true poses in, an 8-bit grey picture out. Seeded; the same calls give the
// same pictures. Corner noise (specification §7.1) is drawn into the picture by bending the printed markers:
// white noise each frame, and a bias that stays while the marker stands still ("per look").
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <random>
#include <span>

#include "tools/sim/optics.hpp"
#include "tools/sim/ray_caster.hpp"
#include "tools/sim/solids.hpp"

namespace armsight::sim {

class Renderer {
 public:
  /// Throws ConfigError for a marker that its dictionary does not have.
  Renderer(const Scene& scene, const MarkerConfig& hand_marker, const NoiseFigures& noise, std::uint64_t seed);

  /// One exposure. `instants`: the world at moments spread evenly over it, its middle among them; the picture is their
  /// mean. Instants that differ by less than 0.1 px on the picture are drawn as one.
  cv::Mat render(std::span<const WorldView> instants);

  const host::Intrinsics& intrinsics() const { return scene_.camera.intrinsics; }

 private:
  /// A marker's pattern and the noise of its corners.
  struct Marker {
    MarkerConfig config;
    host::MarkerPattern pattern;
    host::Corners bias_drawn_at{};
    CornerShift bias_px{};
    CornerShift shift_px{};  ///< of this frame: bias and white noise
  };
  void draw_shift(Marker& marker, const Pose& T_C_M);
  std::shared_ptr<const MarkerPrint> print(const Marker& marker, const Pose& T_C_M) const;
  Pose T_C_object_marker(const WorldView& world) const;
  Stage stage_of(const WorldView& world) const;
  void refresh_still_life(const WorldView& world);
  void draw_instant(const WorldView& world);

  Scene scene_;
  NoiseFigures noise_;
  std::mt19937_64 random_;
  Marker hand_marker_, object_marker_;
  RayCaster caster_;
  Optics optics_;
  Canvas still_life_;      ///< room and table, drawn anew only when camera or object have moved
  Pose still_T_C_B_, still_T_B_O_;
  Canvas canvas_;          ///< the instant drawn last
  WorldView drawn_;
  bool is_drawn_ = false;  ///< canvas_ shows drawn_, with both prints
};

}  // namespace armsight::sim
