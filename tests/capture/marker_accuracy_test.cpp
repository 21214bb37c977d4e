// SPDX-License-Identifier: GPL-3.0-or-later
// What a lab may rely on: markers of 40 px that vibrate, in a film without loss and in a bad one.
#include "capture/track_markers.hpp"
#include "tests/capture/vibrating_markers.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace twang::test {
namespace {

/// How far off a film's vibrating markers were found, both coordinates of both markers.
struct Accuracy {
  double bias_px = 0.0;  ///< largest mean error of a coordinate of a marker
  double rms_px = 0.0;
  double in_sigmas = 0.0;  ///< rms of error over stated sigma
  double found = 0.0;      ///< part of the frames
  double size_px = 0.0;
};

constexpr std::size_t kVibrating = 2;

/// Where a marker is on average while the shutter is open [px].
Eigen::Vector2d exposed_position(const VibratingMarkers& motion,
                                 const Rig& rig,
                                 const FilmOptions& options,
                                 const FilmTruth& truth,
                                 std::size_t frame,
                                 std::size_t marker) {
  constexpr int kParts = 32;
  const double time_s = truth.time_s[frame];
  const auto at = [&](double t) { return motion.state_at(rig, t).markers[marker].position; };
  Eigen::Vector3d moved = Eigen::Vector3d::Zero();
  for (int k = 0; k < kParts; ++k) {
    const double within = options.exposure / options.fps * ((k + 0.5) / kParts - 0.5);
    moved += (at(std::max(0.0, time_s + within)) - at(time_s)) / kParts;
  }
  const double px_per_m = 1e3 / truth.mm_per_px;
  return truth.position_px[frame][marker] + px_per_m * Eigen::Vector2d(moved.x(), -moved.z());
}

Accuracy accuracy_of(MarkerKind kind, FilmOptions options) {
  const TemporaryFolder folder;
  const auto video = folder.path() / "film.mkv";
  const Rig rig = VibratingMarkers::rig(kind);
  const VibratingMarkers motion;
  options.duration_s = 0.4;
  const FilmTruth truth = render_film(
      rig, [&](double time_s) { return motion.state_at(rig, time_s); }, video, options);
  TrackOptions track;
  // A patch shows no id: one of the two places must be given.
  if (kind == MarkerKind::Patch) {
    for (std::size_t i = 0; i < kVibrating; ++i) {
      track.start_px[rig.markers[i].id] = truth.position_px[0][i];
    }
  }
  const TrackResult result = track_markers(rig, video, track);
  Accuracy accuracy;
  accuracy.size_px = 1e3 * rig.markers[0].size_m / truth.mm_per_px;
  double square = 0.0, in_sigmas = 0.0, count = 0.0;
  for (std::size_t i = 0; i < kVibrating; ++i) {
    std::vector<Eigen::Vector2d> errors;
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (std::size_t n = 0; n < truth.time_s.size(); ++n) {
      const Eigen::Vector2d& px = result.tracks[i].position_px[n];
      if (!px.allFinite()) continue;
      errors.push_back(px - exposed_position(motion, rig, options, truth, n, i));
      mean += errors.back();
    }
    mean /= static_cast<double>(errors.size());
    // Where a patch's reference was cut out is its own zero.
    const Eigen::Vector2d zero = kind == MarkerKind::Patch ? mean : Eigen::Vector2d(0.0, 0.0);
    std::size_t k = 0;
    for (std::size_t n = 0; n < truth.time_s.size(); ++n) {
      if (!result.tracks[i].position_px[n].allFinite()) continue;
      const double error = (errors[k++] - zero).squaredNorm();
      square += error;
      in_sigmas += error / std::pow(result.tracks[i].sigma_px[n], 2);
      count += 2.0;
    }
    accuracy.bias_px = std::max(accuracy.bias_px, (mean - zero).cwiseAbs().maxCoeff());
  }
  accuracy.rms_px = std::sqrt(square / count);
  accuracy.in_sigmas = std::sqrt(in_sigmas / count);
  accuracy.found = count / static_cast<double>(2 * kVibrating * truth.time_s.size());
  return accuracy;
}

class MarkerAccuracy : public ::testing::TestWithParam<MarkerKind> {
 protected:
  void print(const Accuracy& accuracy) {
    RecordProperty("bias_px", std::to_string(accuracy.bias_px));
    RecordProperty("rms_px", std::to_string(accuracy.rms_px));
    RecordProperty("error_over_sigma", std::to_string(accuracy.in_sigmas));
    std::printf("%s, %.1f px: bias %.4f px, rms %.4f px, error over sigma %.2f, found %.3f\n",
                std::string(to_string(GetParam())).c_str(),
                accuracy.size_px,
                accuracy.bias_px,
                accuracy.rms_px,
                accuracy.in_sigmas,
                accuracy.found);
  }
};

TEST_P(MarkerAccuracy, OfALosslessFilmIsAHundredthOfAPixelAndKnown) {
  FilmOptions options;
  options.noise = 2.0;
  options.crf = 0;
  const Accuracy accuracy = accuracy_of(GetParam(), options);
  print(accuracy);
  EXPECT_NEAR(accuracy.size_px, 40.0, 2.0);
  EXPECT_EQ(accuracy.found, 1.0);
  EXPECT_LE(accuracy.bias_px, 0.01);
  EXPECT_LE(accuracy.rms_px, 0.02);
  EXPECT_GE(accuracy.in_sigmas, 0.8);
  EXPECT_LE(accuracy.in_sigmas, 1.25);
}

TEST_P(MarkerAccuracy, OfABadFilmIsATenthOfAPixelAndKnown) {
  FilmOptions options;
  options.noise = 4.0;
  options.crf = 27;
  options.exposure = 0.5;
  options.tilt_deg = 8.0;
  options.shake_px = 1.0;
  options.flicker = 0.1;
  const Accuracy accuracy = accuracy_of(GetParam(), options);
  print(accuracy);
  EXPECT_EQ(accuracy.found, 1.0);
  EXPECT_LE(accuracy.rms_px, 0.12);
  EXPECT_GE(accuracy.in_sigmas, 0.5);
  EXPECT_LE(accuracy.in_sigmas, 2.0);
}

INSTANTIATE_TEST_SUITE_P(EachKind,
                         MarkerAccuracy,
                         ::testing::Values(MarkerKind::Cross,
                                           MarkerKind::Dot,
                                           MarkerKind::Ring,
                                           MarkerKind::Checker,
                                           MarkerKind::ArUco,
                                           MarkerKind::AprilTag,
                                           MarkerKind::Patch),
                         [](const ::testing::TestParamInfo<MarkerKind>& kind) {
                           return std::string(to_string(kind.param));
                         });

}  // namespace
}  // namespace twang::test
