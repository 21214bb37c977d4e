// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/find_layout.hpp"
#include "core/error.hpp"
#include "tests/capture/filmed_crossing.hpp"
#include "tests/support/expect_refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>
#include <functional>
#include <string>
#include <vector>

namespace twang::test {
namespace {

/// Equal dots in rows and columns, 12 mm apart; the lowest row is fixed.
Rig grid(int columns, int rows) {
  Rig rig;
  rig.name = "grid";
  rig.camera = Camera{};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      std::string id = "r";
      id.append(std::to_string(row)).append("c").append(std::to_string(column));
      rig.markers.push_back(dot(std::move(id), 12.0 * column, 12.0 * row, row == 0));
    }
  }
  return rig;
}

struct Picture {
  Image image;
  std::vector<Eigen::Vector2d> truth_px;
};

class FindGrid : public ::testing::Test {
 protected:
  /// One frame of the rig, its rows gone sidewise by `gone_mm` a row.
  Picture film(const Rig& rig, FilmOptions options, double gone_mm = 0.0) {
    options.width_px = 520;
    options.height_px = 330;
    options.duration_s = 1.0 / options.fps;
    options.exposure = 0.0;
    const auto path = m_folder.path() / "film.mkv";
    const FilmTruth truth = render_film(
        rig,
        [&](double) {
          FilmedState state = at_rest(rig);
          for (MarkerPose& pose : state.markers) {
            pose.position.x() += 1e-3 * gone_mm * pose.position.z() / 12e-3;
          }
          return state;
        },
        path,
        options);
    return {read_film(path).front(), truth.position_px.front()};
  }
  /// Of the processor: others may be using it too.
  static double seconds_of(const std::function<void()>& work) {
    const std::clock_t start = std::clock();
    work();
    return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  }
  TemporaryFolder m_folder;
};

TEST_F(FindGrid, FindsTwentyEightEqualDotsAtASlant) {
  const Rig rig = grid(7, 4);
  for (const double tilt_deg : {0.0, 20.0, -20.0}) {
    for (const double gone_mm : {0.0, 2.0}) {  // the top row by half a column
      FilmOptions options;
      options.tilt_deg = tilt_deg;
      options.roll_deg = 0.4 * tilt_deg;
      const Picture picture = film(rig, options, gone_mm);
      Layout layout;
      const double seconds =
          seconds_of([&] { layout = find_layout(luma_view(picture.image), rig); });
      for (std::size_t i = 0; i < rig.markers.size(); ++i) {
        const Eigen::Vector2d& found = layout.markers[i].alignment.placement.position_px;
        EXPECT_LT((found - picture.truth_px[i]).norm(), 0.1)
            << rig.markers[i].id << " tilt " << tilt_deg << " gone " << gone_mm;
      }
      RecordProperty("seconds", std::to_string(seconds));
      EXPECT_LT(seconds, 2.0);  // 0.3 s when this was written
    }
  }
}

TEST_F(FindGrid, WithSomeHiddenTheOthersAreWhoTheyAre) {
  const Rig rig = grid(7, 4);
  Picture picture = film(rig, {});
  const std::vector<std::size_t> hidden = {2, 9, 10, 21, 27};
  for (const std::size_t i : hidden) paint_box(picture.image, picture.truth_px[i], 16, 110);
  const PartialLayout layout = search_layout(luma_view(picture.image), rig, {}, "f", "frame 3");
  EXPECT_TRUE(layout.usable);
  EXPECT_EQ(layout.num_found, 23);
  EXPECT_TRUE(holds(layout.problem, "marker 'r0c2' was not found in frame 3"));
  for (std::size_t i = 0; i < rig.markers.size(); ++i) {
    const bool expected = std::find(hidden.begin(), hidden.end(), i) == hidden.end();
    EXPECT_EQ(layout.markers[i].has_value(), expected) << rig.markers[i].id;
    // Where the hidden ones are to be looked for is known too.
    const Eigen::Vector2d due =
        map_point(layout.px_from_plane, plane_position(*rig.camera, rig.markers[i].position));
    EXPECT_LT((due - picture.truth_px[i]).norm(), 0.5) << rig.markers[i].id;
  }
}

TEST_F(FindGrid, RefusesAPartOfAGridThatFitsAtSeveralPlaces) {
  const Picture picture = film(grid(5, 3), {});
  const std::string message =
      refusal_of([&] { static_cast<void>(find_layout(luma_view(picture.image), grid(3, 3))); });
  EXPECT_TRUE(holds(message, "could be one of 3 places")) << message;
  const PartialLayout layout =
      search_layout(luma_view(picture.image), grid(3, 3), {}, "f", "frame 3");
  EXPECT_FALSE(layout.usable);
  EXPECT_TRUE(layout.hopeless);
}

}  // namespace
}  // namespace twang::test
