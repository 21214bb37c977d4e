// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/find_layout.hpp"

#include "capture/render_film.hpp"
#include "core/error.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/capture/filmed_strip.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace twang::test {
namespace {

using Starts = std::map<std::string, Eigen::Vector2d>;

struct Picture {
  Image image;
  std::vector<Eigen::Vector2d> truth_px;
};

class FindLayout : public ::testing::Test {
 protected:
  /// The first frame of a film of the strip, held at the motion's amplitude.
  Picture film(const Rig& rig, const FilmOptions& options, const StripMotion& motion = {}) {
    const auto path = m_folder.path() / "film.mkv";
    const FilmTruth truth = render_film(
        rig, [&](double time_s) { return motion.state_at(rig, time_s); }, path, options);
    return {read_film(path).front(), truth.position_px.front()};
  }
  Picture film(const Rig& rig) { return film(rig, small_film()); }
  /// Markers alone, no part.
  Picture film_markers(const Rig& rig) {
    const auto path = m_folder.path() / "film.mkv";
    const FilmTruth truth = render_film(
        rig, [&](double) { return at_rest(rig); }, path, small_film());
    return {read_film(path).front(), truth.position_px.front()};
  }

  static FilmOptions small_film() {
    FilmOptions options = clean_film(1);
    options.width_px = 400;
    options.height_px = 230;
    options.noise = 2.0;
    return options;
  }

  static void expect_all_found(const Rig& rig, const Picture& picture, const Starts& starts = {}) {
    const Layout layout = find_layout(luma_view(picture.image), rig, starts);
    ASSERT_EQ(layout.markers.size(), rig.markers.size());
    for (std::size_t i = 0; i < rig.markers.size(); ++i) {
      const Eigen::Vector2d found = layout.markers[i].alignment.placement.position_px;
      // One noisy picture, markers of 15 to 20 px; under tilt their affine picture is a hair off.
      EXPECT_LT((found - picture.truth_px[i]).norm(), 0.08) << rig.markers[i].id;
    }
  }

  std::string refusal(const Rig& rig, const Picture& picture, const Starts& starts = {}) {
    return refusal_of(
        [&] { static_cast<void>(find_layout(luma_view(picture.image), rig, starts, "f.mp4")); });
  }

  TemporaryFolder m_folder;
};

/// A few dots on the bench, all alike, that move or not.
Rig dots(const std::vector<Eigen::Vector2d>& places_mm, bool fixed) {
  Rig rig;
  rig.name = "dots";
  rig.camera = Camera{};
  for (const Eigen::Vector2d& place : places_mm) {
    Marker marker;
    marker.id = std::string(1, static_cast<char>('a' + rig.markers.size()));
    marker.size_m = 5e-3;
    marker.position = {1e-3 * place.x(), 0.0, 1e-3 * place.y()};
    marker.fixed = fixed;
    rig.markers.push_back(marker);
  }
  return rig;
}

TEST_F(FindLayout, FindsADeflectedStrip) { expect_all_found(strip_rig(), film(strip_rig())); }

TEST_F(FindLayout, FindsItUnderTiltAndRoll) {
  for (const double sign : {1.0, -1.0}) {
    FilmOptions options = small_film();
    options.tilt_deg = 20.0 * sign;
    options.roll_deg = 20.0 * sign;
    expect_all_found(strip_rig(), film(strip_rig(), options));
  }
}

TEST_F(FindLayout, FindsItOutOfFocus) {
  FilmOptions options = small_film();
  options.defocus_px = 1.2;
  expect_all_found(strip_rig(), film(strip_rig(), options));
}

TEST_F(FindLayout, FindsItWithoutAStatedRelease) {
  Rig rig = strip_rig();
  rig.release.reset();
  expect_all_found(rig, film(rig));
}

TEST_F(FindLayout, FindsEveryKind) {
  for (const MarkerKind kind :
       {MarkerKind::Cross, MarkerKind::Dot, MarkerKind::Ring, MarkerKind::Checker}) {
    const Rig rig = bench_with(kind);
    expect_all_found(rig, film(rig));
  }
}

TEST_F(FindLayout, FindsOneMarkerAlone) {
  const Rig rig = strip_rig(0);
  expect_all_found(rig, film(rig));
}

TEST_F(FindLayout, MapsRestOntoThePicture) {
  const Rig rig = strip_rig();
  StripMotion still;
  still.amplitude_m = 0.0;
  const Picture picture = film(rig, small_film(), still);
  const Layout layout = find_layout(luma_view(picture.image), rig);
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const Eigen::Vector2d mapped =
        layout.to_px(plane_position(*rig.camera, rig.markers[i].position));
    EXPECT_LT((mapped - picture.truth_px[i]).norm(), 0.1);  // of the candidates, not yet refined
  }
}

TEST_F(FindLayout, RefusesOneOfThreeAlike) {
  const Picture picture = film_markers(dots({{0, 0}, {30, 3}, {55, -4}}, true));
  const Rig one = dots({{0, 0}}, false);
  const std::string message = refusal(one, picture);
  EXPECT_TRUE(holds(message, "marker 'a' could be one of 3 places"));
  EXPECT_TRUE(holds(message, "--marker a=x,y"));
}

TEST_F(FindLayout, StartSettlesWhichOneIsMeant) {
  const Picture picture = film_markers(dots({{0, 0}, {30, 3}, {55, -4}}, true));
  const Rig one = dots({{0, 0}}, false);
  const Eigen::Vector2d middle = picture.truth_px[1];
  const Layout layout =
      find_layout(luma_view(picture.image), one, {{"a", middle + Eigen::Vector2d(4.0, -3.0)}});
  EXPECT_LT((layout.markers[0].alignment.placement.position_px - middle).norm(), 0.08);
}

TEST_F(FindLayout, RefusesARowThatFitsAtTwoPlaces) {
  const Picture picture = film_markers(dots({{0, 0}, {20, 0}, {40, 0}, {60, 0}}, true));
  EXPECT_TRUE(holds(refusal(dots({{0, 0}, {20, 0}, {40, 0}}, true), picture), "could be one of 2"));
}

TEST_F(FindLayout, SaysWhichMarkerIsMissing) {
  Rig without_tip = strip_rig();
  without_tip.markers.erase(without_tip.markers.begin());
  const std::string message = refusal(strip_rig(), film(without_tip));
  EXPECT_TRUE(holds(message, "f.mp4: marker 'tip' was not found in the first frame"));
  EXPECT_TRUE(holds(message, "--marker tip=x,y"));
}

TEST_F(FindLayout, RefusesAPictureWithoutMarkers) {
  const Image blank{320, 180, 1, std::vector<std::uint8_t>(320 * 180, 150)};
  EXPECT_TRUE(holds(refusal(strip_rig(), {blank, {}}), "was not found"));
}

TEST_F(FindLayout, RefusesAStartThatNamesNoMarker) {
  const std::string message = refusal(strip_rig(), film(strip_rig()), {{"tipp", {10.0, 10.0}}});
  EXPECT_TRUE(holds(message, "tipp"));
  EXPECT_TRUE(holds(message, "nearest: 'tip'"));
}

TEST_F(FindLayout, RefusesAStartOutsideThePicture) {
  EXPECT_TRUE(holds(refusal(strip_rig(), film(strip_rig()), {{"tip", {400.0, 10.0}}}),
                    "outside the picture"));
}

TEST_F(FindLayout, RefusesAStartWithNoMarkerNearIt) {
  EXPECT_TRUE(holds(refusal(strip_rig(), film(strip_rig()), {{"tip", {200.0, 20.0}}}),
                    "marker 'tip' was not found near (200, 20)"));
}

TEST_F(FindLayout, RefusesTwoStartsOnOneMarker) {
  const Picture picture = film(strip_rig());
  EXPECT_TRUE(holds(refusal(strip_rig(),
                            picture,
                            {{"bench_1", picture.truth_px[1]}, {"bench_2", picture.truth_px[1]}}),
                    "'bench_1' and 'bench_2' were both placed"));
}

TEST_F(FindLayout, RefusesTagsThatDoNotExist) {
  const Picture picture = film(strip_rig());
  Rig rig = strip_rig();
  rig.markers[0].kind = MarkerKind::AprilTag;
  rig.markers[0].dictionary = "tag36h12";
  EXPECT_TRUE(holds(refusal(rig, picture), "'tag36h12', must be one of tag16h5, tag25h9"));
}

}  // namespace
}  // namespace twang::test
