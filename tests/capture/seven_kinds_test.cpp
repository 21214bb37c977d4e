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

#include <cmath>
#include <filesystem>
#include <string>
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
  for (const double size_px : {16.0, 24.0, 40.0}) {
    FilmOptions options = film_of_seven(size_px);
    options.tilt_deg = 12.0;
    options.roll_deg = -14.0;
    options.width_px = 2 * (options.width_px * 10 / 19);
    options.height_px = 2 * (options.height_px * 10 / 13);
    for (const double turn_deg : {65.0, 160.0, 250.0}) {
      expect_found(rig, picture(rig, seven_at_rest(rig, turn_deg * kRadiansPerDegree), options));
    }
  }
}

}  // namespace
}  // namespace twang::test
