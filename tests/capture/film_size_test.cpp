// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/constants.hpp"
#include "tests/capture/filmed_rig.hpp"
#include "tests/support/temporary_folder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

namespace twang::test {
namespace {

TEST(RenderFilm, DefaultFilmStaysBelowThreeMegabytes) {
  const Rig rig = bench_with(MarkerKind::Cross);
  const TemporaryFolder folder;
  const auto path = folder.path() / "film.mp4";
  const auto swinging = [&](double time_s) {
    FilmedState state = at_rest(rig);
    const double lift = 3e-3 * std::exp(-5.0 * time_s) * std::cos(kTwoPi * 48.0 * time_s);
    state.markers[0].position.z() += lift;
    state.part_faces.push_back({Eigen::Vector3d(-30e-3, 0.0, 0.0),
                                Eigen::Vector3d(5e-3, 0.0, lift),
                                Eigen::Vector3d(5e-3, 0.0, lift + 2e-3),
                                Eigen::Vector3d(-30e-3, 0.0, 2e-3)});
    return state;
  };
  const FilmTruth truth = render_film(rig, swinging, path);
  EXPECT_EQ(truth.time_s.size(), 360U);
  EXPECT_EQ(read_film(path).size(), 360U);
  EXPECT_LT(std::filesystem::file_size(path), 3000000U);
}

}  // namespace
}  // namespace twang::test
