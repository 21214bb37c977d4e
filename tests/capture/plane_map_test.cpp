// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/plane_map.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "tests/capture/slanted_plane.hpp"
#include "tests/support/expect_refusal.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <vector>

namespace twang::test {
namespace {

/// Fixed markers and a moving one seen for a while by a camera that may shake.
class Film {
 public:
  explicit Film(const Points& fixed_m, double sigma_px, bool with_tip = true) {
    for (const auto& place : fixed_m) add(place, true, sigma_px);
    if (with_tip) add({76e-3, -1e-3}, false, sigma_px);
  }

  /// Moves a marker aside in the picture from a frame on.
  void push(std::size_t marker, int from, const Eigen::Vector2d& by_px) {
    m_markers[marker].pushed_from = from;
    m_markers[marker].pushed_by = by_px;
  }
  void hide(std::size_t marker, int from, int to) {
    m_markers[marker].hidden_from = from;
    m_markers[marker].hidden_to = to;
  }
  /// The paper lies elsewhere than the rig says.
  void misplace(std::size_t marker, const Eigen::Vector2d& by_m) {
    m_markers[marker].misplaced = by_m;
  }

  PlaneMap map(const std::function<Homography(int)>& camera_at) {
    constexpr int kFrames = 200;
    std::mt19937 random(3);
    for (std::size_t i = 0; i < m_markers.size(); ++i) {
      std::normal_distribution<double> noise(0.0, m_markers[i].sigma_px);
      Track& track = m_markers[i];
      for (int n = 0; n < kFrames; ++n) {
        const double swing = track.fixed ? 0.0 : 3e-3 * std::exp(-n / 30.0) * std::cos(0.9 * n);
        const Eigen::Vector2d place = track.rest + track.misplaced + Eigen::Vector2d(0.0, swing);
        track.position_px.push_back(map_point(camera_at(n), place) +
                                    Eigen::Vector2d(noise(random), noise(random)));
        if (n >= track.pushed_from) track.position_px.back() += track.pushed_by;
        if (n >= track.hidden_from && n < track.hidden_to)
          track.position_px.back().setConstant(kNaN);
        track.sigma.push_back(track.sigma_px);
      }
    }
    std::vector<PlaneMarker> seen;
    for (const Track& track : m_markers) {
      seen.push_back({"m", track.fixed, track.rest, 5e-3, 30.0, &track.position_px, &track.sigma});
    }
    return map_plane(seen);
  }

 private:
  struct Track {
    Eigen::Vector2d rest = Eigen::Vector2d::Zero();
    bool fixed = false;
    double sigma_px = 0.0;
    Points position_px;
    std::vector<double> sigma;
    int pushed_from = 1 << 30;
    Eigen::Vector2d pushed_by = Eigen::Vector2d::Zero();
    int hidden_from = 0;
    int hidden_to = 0;
    Eigen::Vector2d misplaced = Eigen::Vector2d::Zero();
  };
  void add(const Eigen::Vector2d& rest, bool fixed, double sigma_px) {
    Track track;
    track.rest = rest;
    track.fixed = fixed;
    track.sigma_px = sigma_px;
    m_markers.push_back(track);
  }
  std::vector<Track> m_markers;
};

Homography steady(int) { return px_from_plane(); }

Homography shaken(int frame) {
  const double t = 0.05 * frame;
  Homography shake = Homography::Identity();
  shake.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(0.004 * std::sin(1.3 * t)).toRotationMatrix();
  shake.topRightCorner<2, 1>() << 2.0 * std::sin(t), 1.5 * std::cos(1.7 * t);
  return shake * px_from_plane();
}

/// Largest error of the map at a place, over the film [m].
double largest_error(const PlaneMap& map,
                     const std::function<Homography(int)>& camera_at,
                     const Eigen::Vector2d& place) {
  double largest = 0.0;
  for (int n = 0; n < 200; ++n) {
    const Eigen::Vector2d px = map_point(camera_at(n), place);
    largest =
        std::max(largest, (map_point(map.at(static_cast<std::size_t>(n)), px) - place).norm());
  }
  return largest;
}

const Eigen::Vector2d kTip_m(76e-3, -1e-3);
constexpr double kSigma_px = 0.02;

TEST(PlaneMap, SteadyCameraGetsOneMapForAllFrames) {
  const PlaneMap map = Film(kBench_m, kSigma_px).map(steady);
  EXPECT_EQ(map.plane_from_px.size(), 1U);
  // 0.02 px over sqrt(200) frames, at 6 px/mm: a quarter of a micrometre; times four.
  EXPECT_LT(largest_error(map, steady, kTip_m), 1e-6);
}

TEST(PlaneMap, ShakingCameraIsFollowedFrameByFrame) {
  const PlaneMap map = Film(kBench_m, kSigma_px).map(shaken);
  EXPECT_EQ(map.plane_from_px.size(), 200U);
  // A frame's own 0.02 px, about four sigmas.
  EXPECT_LT(largest_error(map, shaken, kTip_m), 15e-6);
}

TEST(PlaneMap, CameraThatSwingsSidewaysIsFollowedByHomographies) {
  for (const double slant : {0.3, 0.6, 1.0}) {  // up to 40 px at the far markers, 1 px at the near
    const auto swinging = [&](int n) {
      Homography map = px_from_plane();
      map(2, 0) += slant * std::sin(0.05 * n);
      return map;
    };
    const PlaneMap map = Film(kBench_m, kSigma_px).map(swinging);
    EXPECT_LT(largest_error(map, swinging, kTip_m), 20e-6) << slant;
    EXPECT_EQ(map.frames_left_out, std::vector<int>(5, 0)) << slant;
  }
}

TEST(PlaneMap, CameraThatPansIsFollowedFromTenthsOfAPixelToAHundred) {
  // A lens of 1500 px: what a pan does beyond a similarity grows from 1/50 px to 5 px.
  Homography lens;
  lens << 1500.0, 0.0, 320.0, 0.0, 1500.0, 160.0, 0.0, 0.0, 1.0;
  for (const double pan_rad : {0.0002, 0.0005, 0.001, 0.002, 0.005, 0.008, 0.01, 0.02, 0.07}) {
    const auto panning = [&](int n) {
      const Eigen::AngleAxisd turn(pan_rad * std::sin(0.05 * n), Eigen::Vector3d::UnitY());
      return Homography(lens * turn.toRotationMatrix() * lens.inverse() * px_from_plane());
    };
    const PlaneMap map = Film(kBench_m, kSigma_px).map(panning);
    // As above: a frame's own 0.02 px, about four sigmas, or slant of that size not taken out.
    EXPECT_LT(largest_error(map, panning, kTip_m), 20e-6) << pan_rad;
    EXPECT_EQ(map.frames_left_out, std::vector<int>(5, 0)) << pan_rad;
  }
}

TEST(PlaneMap, TwoFixedMarkersFollowAShakingCamera) {
  const auto flat = [](int n) {
    Homography map = shaken(n) * px_from_plane().inverse();
    Homography similar = Homography::Identity();
    similar.topLeftCorner<2, 2>() *= 6000.0;
    return Homography(map * similar);
  };
  const PlaneMap map = Film({kBench_m[0], kBench_m[2]}, kSigma_px).map(flat);
  EXPECT_LT(largest_error(map, flat, kTip_m), 20e-6);
}

TEST(PlaneMap, OneFixedMarkerTakesTheShiftOut) {
  const auto shifting = [](int n) {
    Homography map = Homography::Identity();
    map.topLeftCorner<2, 2>() *= 6000.0;
    map.topRightCorner<2, 1>() << 2.0 * std::sin(0.05 * n), 1.5 * std::cos(0.08 * n);
    return map;
  };
  const PlaneMap map = Film({kBench_m[0]}, kSigma_px).map(shifting);
  // The scale is from where the tip settles: what is left of its swing there, over the base.
  EXPECT_LT(largest_error(map, shifting, kTip_m), 40e-6);
  EXPECT_NEAR(map.mm_per_px, 1.0 / 6.0, 1e-3);
}

TEST(PlaneMap, WithoutFixedMarkersTheSettledOnesGiveIt) {
  const auto flat = [](int) {
    Homography map = Homography::Identity();
    map.topLeftCorner<2, 2>() = 6000.0 * Eigen::Rotation2Dd(0.1).toRotationMatrix();
    return map;
  };
  const PlaneMap alone = Film({}, kSigma_px).map(flat);
  EXPECT_NEAR(alone.mm_per_px, 5.0 / 30.0, 1e-12);  // the marker's size in mm over its size in px
  EXPECT_EQ(alone.plane_from_px.size(), 1U);
}

TEST(PlaneMap, CameraThatTurnsAndZoomsByMuchIsFollowed) {
  const auto turning = [](int n) {
    Homography turn = Homography::Identity();
    turn.topLeftCorner<2, 2>() = (1.0 + 0.03 * std::sin(0.04 * n)) *
                                 Eigen::Rotation2Dd(0.15 * std::sin(0.03 * n)).toRotationMatrix();
    turn.topRightCorner<2, 1>() << 12.0 * std::sin(0.05 * n), 9.0 * std::cos(0.07 * n);
    return Homography(turn * px_from_plane());
  };
  const PlaneMap map = Film(kBench_m, kSigma_px).map(turning);
  // As for a camera that only shakes: a frame's own 0.02 px, about four sigmas.
  EXPECT_LT(largest_error(map, turning, kTip_m), 15e-6);
}

TEST(PlaneMap, NoiseOfEachFramesMapIsWhatItErrsBy) {
  for (const auto& camera :
       {std::function<Homography(int)>(shaken), std::function<Homography(int)>([](int n) {
          Homography map = px_from_plane();
          map(2, 0) += 0.6 * std::sin(0.05 * n);
          return map;
        })}) {
    const PlaneMap map = Film(kBench_m, kSigma_px).map(camera);
    ASSERT_EQ(map.noise_m.size(), 5U);
    double in_sigmas = 0.0;
    for (int n = 0; n < 200; ++n) {
      const auto frame = static_cast<std::size_t>(n);
      const Eigen::Vector2d px = map_point(camera(n), kTip_m);
      in_sigmas += (map_point(map.at(frame), px) - kTip_m).squaredNorm() /
                   (2.0 * 200.0 * std::pow(map.noise_m[4][frame], 2));
    }
    // 400 values of chi-square: 7 % of one sigma; the place of the tip in a frame moves by its
    // swing.
    EXPECT_NEAR(std::sqrt(in_sigmas), 1.0, 0.15);
    EXPECT_EQ(map.noise_m[0][7], 0.0);  // a fixed marker
  }
}

/// A camera's map with one fixed marker pushed aside from some frame on.
PlaneMap map_with_pushed(const Points& fixed_m,
                         const std::function<Homography(int)>& camera_at,
                         const Eigen::Vector2d& push_px) {
  Film film(fixed_m, kSigma_px);
  film.push(1, 60, push_px);
  return film.map(camera_at);
}

TEST(PlaneMap, FixedMarkerThatIsPushedIsLeftOutFromThenOn) {
  const auto flat = [](int n) {
    Homography similar = Homography::Identity();
    similar.topLeftCorner<2, 2>() *= 6000.0;
    return Homography(shaken(n) * px_from_plane().inverse() * similar);
  };
  const auto flat_and_still = [&](int) { return flat(0); };
  const Points three = {kBench_m[0], kBench_m[1], kBench_m[2]};
  const Points two = {kBench_m[0], kBench_m[1]};
  struct Case {
    Points fixed_m;
    std::function<Homography(int)> camera;
    double bound_m;
  };
  // A push of 3 px would shift the tip by 0.2 mm and more.
  const std::vector<Case> cases = {{kBench_m, steady, 2e-6},
                                   {kBench_m, shaken, 20e-6},
                                   {three, flat, 25e-6},
                                   {two, flat_and_still, 3e-6}};
  for (const Case& each : cases) {
    const PlaneMap map = map_with_pushed(each.fixed_m, each.camera, {2.0, -2.2});
    EXPECT_LT(largest_error(map, each.camera, kTip_m), each.bound_m) << each.fixed_m.size();
    EXPECT_EQ(map.frames_left_out[1], 140) << each.fixed_m.size();
    EXPECT_EQ(map.frames_left_out[0], 0) << each.fixed_m.size();
    EXPECT_TRUE(holds(map.notes.back().text, "in 140 of 200 frames (first 60)"));
  }
}

TEST(PlaneMap, FixedMarkerThatIsHiddenForAWhileDoesNoHarm) {
  Film film(kBench_m, kSigma_px);
  film.hide(2, 0, 90);  // its mean over the rest is not the others' mean
  film.hide(0, 120, 170);
  EXPECT_LT(largest_error(film.map(shaken), shaken, kTip_m), 25e-6);
}

TEST(PlaneMap, ShakeBelowTheNoiseIsNotFollowedAndAboveItIs) {
  for (const double shake_px : {0.2 * kSigma_px, 3.0 * kSigma_px}) {
    const auto shaking = [&](int n) {
      Homography shift = Homography::Identity();
      shift.topRightCorner<2, 1>() << 1.4 * shake_px * std::sin(0.1 * n),
          1.4 * shake_px * std::cos(0.07 * n);
      return Homography(shift * px_from_plane());
    };
    const PlaneMap map = Film(kBench_m, kSigma_px).map(shaking);
    EXPECT_EQ(map.plane_from_px.size(), shake_px < kSigma_px ? 1U : 200U);
  }
}

TEST(PlaneMap, MisplacedPapersShowInResidualAndScale) {
  Points known = kBench_m;
  known.emplace_back(40e-3, 10e-3);
  known.emplace_back(30e-3, -20e-3);
  Film film(known, kSigma_px);
  film.misplace(4, {0.3e-3, 0.0});
  film.misplace(1, {0.0, -0.2e-3});
  const PlaneMap map = film.map(steady);
  // Two of six papers off by 0.3 and 0.2 mm: 0.15 mm rms before the fit gives way to them.
  EXPECT_GT(map.residual_mm, 0.04);
  EXPECT_LT(map.residual_mm, 0.15);
  EXPECT_NEAR(map.residual_px * map.mm_per_px, map.residual_mm, 1e-12);
  // About that over the 40 mm from the middle to the papers.
  EXPECT_GT(map.scale_sigma_rel, 0.5e-3);
  EXPECT_LT(map.scale_sigma_rel, 10e-3);
  EXPECT_TRUE(std::isnan(Film(kBench_m, kSigma_px).map(steady).scale_sigma_rel));
}

TEST(PlaneMap, ResidualIsTheRmsOfTheFixedMarkers) {
  Points misplaced = kBench_m;
  misplaced.emplace_back(40e-3, 0.0);
  misplaced.emplace_back(60e-3, -10e-3);
  EXPECT_LT(Film(misplaced, kSigma_px).map(steady).residual_px, 0.01);
}

TEST(SettledPosition, SuppressesWhatIsLeftOfTheVibration) {
  Points positions;
  for (int n = 0; n < 300; ++n) positions.emplace_back(7.0 + std::cos(0.8 * n), 3.0);
  // 90 frames under a Hann window: eleven periods, side lobes under 1e-3.
  EXPECT_NEAR(settled_position(positions).x(), 7.0, 1e-3);
  EXPECT_NEAR(settled_position(positions).y(), 3.0, 1e-12);
  positions.assign(20, Eigen::Vector2d::Constant(kNaN));
  EXPECT_FALSE(settled_position(positions).allFinite());
}

}  // namespace
}  // namespace twang::test
