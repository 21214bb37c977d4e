// SPDX-License-Identifier: GPL-3.0-or-later
// Every kind of marker, found and followed in films of one rig that has them all.
#include "tests/capture/seven_kinds.hpp"

#include "capture/find_layout.hpp"
#include "capture/fit_marker.hpp"
#include "capture/track_markers.hpp"
#include "core/units.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace twang::test {
namespace {

/// A picture and where the markers are in it.
struct Seen {
  Image image;
  std::vector<Eigen::Vector2d> truth_px;
  double size_px = 0.0;
};

class SevenKinds : public ::testing::Test {
 protected:
  Seen picture(const Rig& rig, const FilmedState& state, const FilmOptions& options) {
    const std::filesystem::path film = m_folder / "picture.mkv";
    const FilmTruth truth = render_film(
        rig, [&](double) { return state; }, film, options);
    return {read_film(film).front(),
            truth.position_px.front(),
            kKindSize_m * kMillimetresPerMetre / truth.mm_per_px};
  }
  TemporaryFolder m_folder;
};

/// All markers must be found; those that are printed to a tenth of a pixel.
void expect_found(const Rig& rig, const Seen& seen) {
  const Layout layout = find_layout(luma_view(seen.image), rig);
  ASSERT_EQ(layout.markers.size(), rig.markers.size());
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const MarkerAlignment& found = layout.markers[i].alignment;
    const double error = (found.placement.position_px - seen.truth_px[i]).norm();
    // Noise of 2 grey levels moves the smallest by a few hundredths of a pixel. A patch is where
    // the others put it: the map is a fit to eleven of them.
    const bool patch = rig.markers[i].kind == MarkerKind::Patch;
    EXPECT_LT(error, patch ? 0.3 : 0.1) << rig.markers[i].id << " of " << seen.size_px << " px";
    EXPECT_NEAR(placed_size_px(found.placement) / seen.size_px, 1.0, 0.06) << rig.markers[i].id;
  }
}

TEST_F(SevenKinds, AreFoundFrom16Pixels) {
  const Rig rig = rig_of_seven_kinds();
  for (const double size_px : {16.0, 24.0, 40.0}) {
    const Seen seen = picture(rig, seven_at_rest(rig), film_of_seven(size_px));
    EXPECT_NEAR(seen.size_px, size_px, 0.2 * size_px);
    expect_found(rig, seen);
  }
}

TEST_F(SevenKinds, AreFoundTurnedAndTilted) {
  const Rig rig = rig_of_seven_kinds();
  for (const auto& [size_px, turn_deg] :
       {std::pair{16.0, 65.0}, std::pair{24.0, 160.0}, std::pair{40.0, 250.0}}) {
    FilmOptions options = film_of_seven(size_px);
    options.tilt_deg = 12.0;
    options.roll_deg = -14.0;
    options.width_px = 2 * (options.width_px * 10 / 19);
    options.height_px = 2 * (options.height_px * 10 / 13);
    expect_found(rig, picture(rig, seven_at_rest(rig, turn_deg * kRadiansPerDegree), options));
  }
}

/// Errors of a track: their mean, and their scatter about it.
struct TrackErrors {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  double rms = 0.0;             ///< of one coordinate, about the mean
  double over_sigma = 0.0;      ///< rms of error over stated sigma
  double worst_by_phase = 0.0;  ///< largest mean of the errors in y in a fifth of a pixel's phase
  int count = 0;
};

TrackErrors errors_of(const MarkerTrack& track, const FilmTruth& truth, std::size_t marker) {
  TrackErrors result;
  std::vector<std::size_t> found;
  for (std::size_t n = 0; n < track.position_px.size(); ++n) {
    if (!track.position_px[n].allFinite()) continue;
    found.push_back(n);
    result.mean += track.position_px[n] - truth.position_px[n][marker];
  }
  result.count = static_cast<int>(found.size());
  result.mean /= result.count;
  constexpr std::size_t kBins = 5;
  std::array<double, kBins> sum{};
  std::array<double, kBins> num{};
  for (const std::size_t n : found) {
    const Eigen::Vector2d error = track.position_px[n] - truth.position_px[n][marker] - result.mean;
    result.rms += 0.5 * error.squaredNorm() / result.count;
    result.over_sigma += 0.5 * error.squaredNorm() / std::pow(track.sigma_px[n], 2) / result.count;
    const double y = truth.position_px[n][marker].y();
    const auto bin = static_cast<std::size_t>(kBins * (y - std::floor(y)));
    sum[bin] += error.y();
    num[bin] += 1.0;
  }
  result.rms = std::sqrt(result.rms);
  result.over_sigma = std::sqrt(result.over_sigma);
  for (std::size_t b = 0; b < kBins; ++b) {
    if (num[b] > 0.0) {
      result.worst_by_phase = std::max(result.worst_by_phase, std::abs(sum[b] / num[b]));
    }
  }
  return result;
}

/// The rig with the dots on the bench and, of the seven, these.
Rig rig_of(const std::vector<MarkerKind>& kinds) {
  Rig rig = rig_of_seven_kinds();
  std::erase_if(rig.markers, [&](const Marker& marker) {
    return !marker.fixed && std::find(kinds.begin(), kinds.end(), marker.kind) == kinds.end();
  });
  return rig;
}

TEST_F(SevenKinds, TagsAndPatchesAreFollowedToAHundredthOfAPixel) {
  const Rig rig = rig_of({MarkerKind::ArUco, MarkerKind::AprilTag, MarkerKind::Patch});
  FilmOptions options = film_of_seven(37.0);
  options.duration_s = 0.5;
  const std::filesystem::path film = m_folder / "swinging.mkv";
  const FilmTruth truth = render_film(
      rig, [&](double time_s) { return seven_swinging(rig, 1e-3, time_s); }, film, options);
  EXPECT_NEAR(kKindSize_m * kMillimetresPerMetre / truth.mm_per_px, 40.0, 3.0);
  const TrackResult result = track_markers(rig, film);
  for (std::size_t i = 0; i < 3; ++i) {
    const TrackErrors errors = errors_of(result.tracks[i], truth, i);
    const std::string& id = rig.markers[i].id;
    EXPECT_EQ(errors.count, 120) << id;
    // A patch is where it was cut out: an offset that never changes.
    if (rig.markers[i].kind != MarkerKind::Patch) {
      EXPECT_LT(errors.mean.norm(), 0.005) << id;  // 240 coordinates that scatter by 0.006 px
    }
    EXPECT_LT(errors.rms, 0.01) << id;  // what noise of 2 grey levels leaves is half of that
    EXPECT_LT(errors.worst_by_phase, 0.01) << id;
    RecordProperty(id + "_rms_px", std::to_string(errors.rms));
    RecordProperty(id + "_worst_by_phase_px", std::to_string(errors.worst_by_phase));
    RecordProperty(id + "_over_sigma", std::to_string(errors.over_sigma));
  }
}

TEST_F(SevenKinds, PatchIsNotDrawnToPlacesBetweenPixels) {
  const Rig rig = rig_of({MarkerKind::Patch});
  // The finest waves of the smaller are three pixels long.
  for (const double size_px : {16.0, 42.0}) {
    FilmOptions options = film_of_seven(size_px);
    options.exposure = 0.0;
    options.duration_s = 100 / options.fps;
    const double shift_m = 0.05 * kKindSize_m / size_px;  // in a frame
    const std::filesystem::path film = m_folder / "creeping.mkv";
    const FilmTruth truth = render_film(
        rig,
        [&](double time_s) {
          FilmedState state = seven_at_rest(rig);
          state.markers[0].position +=
              shift_m * std::round(time_s * options.fps) * Eigen::Vector3d(0.6, 0.0, 1.0);
          return state;
        },
        film,
        options);
    const TrackErrors errors = errors_of(track_markers(rig, film).tracks[0], truth, 0);
    EXPECT_EQ(errors.count, 100);
    // Twenty frames in each fifth of a pixel: the mean of the smaller's noise scatters by 0.003 px.
    EXPECT_LT(errors.worst_by_phase, 0.01) << size_px << " px";
    EXPECT_LT(errors.rms, size_px < 20.0 ? 0.02 : 0.01) << size_px << " px";
  }
}

TEST_F(SevenKinds, OtherTagsAreNotTakenForIt) {
  // Neighbours in the dictionary stand where the tag should be, and beside; it stands elsewhere.
  Rig filmed = rig_of({MarkerKind::ArUco, MarkerKind::AprilTag, MarkerKind::Checker});
  Rig wanted = filmed;
  for (Marker& marker : filmed.markers) {
    if (marker.kind == MarkerKind::ArUco || marker.kind == MarkerKind::AprilTag) ++marker.tag;
  }
  const Seen seen = picture(filmed, seven_at_rest(filmed), film_of_seven(24.0));
  expect_found(filmed, seen);
  const std::string refusal = refusal_of([&] { (void)find_layout(luma_view(seen.image), wanted); });
  EXPECT_TRUE(holds(refusal, "marker 'aruco' was not found"));
}

class PatchOfABench : public SevenKinds {
 protected:
  const Rig m_rig = rig_of({MarkerKind::Patch});
  std::string refusal(const Rig& rig,
                      const Image& image,
                      const std::map<std::string, Eigen::Vector2d>& start_px = {}) {
    return refusal_of([&] { (void)find_layout(luma_view(image), rig, start_px, "film.mp4"); });
  }
};

TEST_F(PatchOfABench, StandsWhereItIsSaidToStand) {
  const Seen seen = picture(m_rig, seven_at_rest(m_rig), film_of_seven(24.0));
  const Eigen::Vector2d said = seen.truth_px[0] + Eigen::Vector2d(2.25, -1.5);
  const Layout layout = find_layout(luma_view(seen.image), m_rig, {{"patch", said}});
  EXPECT_EQ(layout.markers[0].alignment.placement.position_px, said);
  EXPECT_GT(layout.markers[0].alignment.score, 0.95);
}

TEST_F(PatchOfABench, MovesWithThePrintedMarkerBesideIt) {
  const Rig rig = rig_of({MarkerKind::AprilTag, MarkerKind::Patch});
  FilmedState bent = seven_at_rest(rig);
  bent.markers[0].position.z() += 5e-3;
  bent.markers[1].position.z() += 5e-3;
  const Seen seen = picture(rig, bent, film_of_seven(24.0));
  const Layout layout = find_layout(luma_view(seen.image), rig);
  EXPECT_LT((layout.markers[1].alignment.placement.position_px - seen.truth_px[1]).norm(), 0.5);
}

TEST_F(PatchOfABench, TwoOfThemWithStatedPlacesNeedNothingElse) {
  Rig rig = rig_of({MarkerKind::ArUco, MarkerKind::AprilTag});
  std::erase_if(rig.markers, [](const Marker& marker) { return marker.fixed; });
  for (Marker& marker : rig.markers) marker.kind = MarkerKind::Patch;
  FilmOptions options = film_of_seven(24.0);
  options.height_px = 180;
  const Seen seen = picture(rig, seven_at_rest(rig), options);
  const Layout layout = find_layout(
      luma_view(seen.image), rig, {{"aruco", seen.truth_px[0]}, {"apriltag", seen.truth_px[1]}});
  EXPECT_NEAR(placed_size_px(layout.markers[0].alignment.placement), seen.size_px, 1e-6);
  EXPECT_TRUE(holds(refusal(rig, seen.image, {{"aruco", seen.truth_px[0]}}),
                    "the place of patch 'apriltag' is not known, must be given by --marker "
                    "apriltag=x,y"));
  rig.markers.pop_back();
  EXPECT_TRUE(
      holds(refusal(rig, seen.image, {{"aruco", seen.truth_px[0]}}), "has no marker but patches"));
}

TEST_F(PatchOfABench, IsRefusedWithoutEnoughTexture) {
  Seen seen = picture(m_rig, seven_at_rest(m_rig), film_of_seven(24.0));
  // On the bench, which is all but plain: noise is no texture.
  const Eigen::Vector2d plain = seen.truth_px[0] - Eigen::Vector2d(100.0, 0.0);
  EXPECT_TRUE(holds(refusal(m_rig, seen.image, {{"patch", plain}}), "film.mp4: patch 'patch' at"));
  EXPECT_TRUE(holds(refusal(m_rig, seen.image, {{"patch", plain}}), "too little texture"));
  // Stripes fix one coordinate alone.
  const auto at = [&](int x, int y) -> std::uint8_t& {
    return seen.image.pixels[static_cast<std::size_t>(y * seen.image.width_px + x)];
  };
  const Eigen::Vector2i middle = seen.truth_px[0].array().round().cast<int>();
  for (int y = -20; y <= 20; ++y) {
    for (int x = -20; x <= 20; ++x) {
      at(middle.x() + x, middle.y() + y) =
          static_cast<std::uint8_t>(120 + 60 * ((x + 2 * y + 90) / 4 % 2));
    }
  }
  EXPECT_TRUE(holds(refusal(m_rig, seen.image), "too little texture to fix both coordinates"));
}

TEST_F(PatchOfABench, IsRefusedAtThePicturesEdge) {
  const Seen seen = picture(m_rig, seven_at_rest(m_rig), film_of_seven(24.0));
  EXPECT_TRUE(holds(refusal(m_rig, seen.image, {{"patch", {5.0, 50.0}}}),
                    "does not lie within the picture"));
}

}  // namespace
}  // namespace twang::test
