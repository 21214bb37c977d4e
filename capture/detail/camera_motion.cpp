// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/camera_motion.hpp"

#include "capture/detail/motion_fit.hpp"

#include <algorithm>
#include <utility>

namespace twang::detail {
namespace {

// Gain in chi-square that a parameter must bring: a parameter's own noise costs one, and its bias
// when left out must cost more than that.
constexpr double kGainPerParameter = 2.0;
// The same where nothing is left to judge the stated sigmas by; they hold to about a factor 1.5.
constexpr double kGainUnchecked = 3.0;
// Below this scatter a camera is at rest, or a similarity enough, whatever the sigmas say.
constexpr double kStillCamera_px = 0.01;
// Reduced chi-square up to which markers are explained, their sigmas holding to a factor two.
constexpr double kStandsStill = 4.0;
// Share of sightings left out that is more than misreadings and a push late in the film.
constexpr double kUnexplained = 0.1;

/// Whether the freer motion lowers the error.
bool pays(const MotionFit& simple, const MotionFit& free) {
  constexpr double kChecked = 100.0;  // degrees of freedom that tell the noise to a tenth
  // What is left by a motion that leaves out so much is no noise: it is not how the camera moved.
  const bool checked = free.freedom > kChecked && free.share_left_out < kUnexplained;
  const double noise = checked ? std::max(1.0, free.reduced()) : 1.0;
  const double gain = (simple.cost - free.cost) / noise;
  return gain >
         (checked ? kGainPerParameter : kGainUnchecked) * (free.parameters - simple.parameters);
}

/// Whether some markers were touched while the camera stood.
bool only_some_move(const MotionFit& still, std::size_t count) {
  bool some_moved = false;
  bool some_stood = false;
  for (std::size_t i = 0; i < count; ++i) {
    if (still.leaves_out(i)) some_moved = true;
    if (!still.leaves_out(i) && still.own_chi_square(i) < kStandsStill) some_stood = true;
  }
  return some_moved && some_stood;
}

/// Whether a motion leaves nothing to explain. A small rms alone does not say so: the two markers
/// kept in a frame follow any similarity exactly.
bool explains_all(const MotionFit& moved) {
  return moved.share_left_out == 0.0 && moved.rms_px < kStillCamera_px;
}

/// Whether a similarity explains three markers or more all along, and others were touched.
bool others_were_touched(const MotionFit& moved, std::size_t count) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count; ++i) kept += moved.leaves_out(i) ? 0 : 1;
  return kept >= 3 && kept < count && moved.reduced() < kStandsStill;
}

}  // namespace

int CameraMotion::frames_left_out(std::size_t marker) const {
  return static_cast<int>(std::count(left_out[marker].begin(), left_out[marker].end(), true));
}

CameraMotion find_camera_motion(const std::vector<FixedMarker>& markers) {
  const double scatter_px = scatter_of(markers);
  const auto told = [&](MotionFit&& fit) {
    CameraMotion motion = std::move(fit).result();
    motion.scatter_px = scatter_px;
    return motion;
  };
  MotionFit still(markers, std::nullopt);
  if (scatter_px < kStillCamera_px || only_some_move(still, markers.size())) {
    return told(std::move(still));
  }
  MotionFit moved(markers, markers.size() == 1 ? MapKind::Shift : MapKind::Similarity);
  if (!pays(still, moved)) return told(std::move(still));
  if (!span_plane(moved.mean_px())) return told(std::move(moved));
  // What a similarity leaves out may be the picture's slant that changes.
  MotionFit slanted(markers, MapKind::Projective);
  const bool fits =
      explains_all(moved) || others_were_touched(moved, markers.size()) || !pays(moved, slanted);
  return told(std::move(fits ? moved : slanted));
}

}  // namespace twang::detail
