// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/error.hpp"
#include "rigs/load_rig.hpp"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace twang {
namespace {

std::filesystem::path shipped(const char* name) {
  return std::filesystem::path(TWANG_SOURCE_DIR) / "rigs" / name;
}

constexpr RigNeeds kCalibrateFromFilm = {
    .part = true, .clamp = true, .film = true, .observable = true};

/// Smallest angle of the triangles of fixed markers is far from zero: they span the plane.
double spread_of_fixed_markers_m(const Rig& rig) {
  std::vector<Eigen::Vector3d> points;
  for (const Marker& marker : rig.markers) {
    if (marker.fixed) points.push_back(marker.position);
  }
  double smallest = INFINITY;
  for (std::size_t a = 0; a < points.size(); ++a) {
    for (std::size_t b = a + 1; b < points.size(); ++b) {
      for (std::size_t c = b + 1; c < points.size(); ++c) {
        const Eigen::Vector3d ab = points[b] - points[a];
        const Eigen::Vector3d ac = points[c] - points[a];
        const Eigen::Vector3d bc = points[c] - points[b];
        const double longest = std::max({ab.norm(), ac.norm(), bc.norm()});
        smallest = std::min(smallest, ab.cross(ac).norm() / longest);
      }
    }
  }
  return smallest;
}

std::size_t num_fixed(const Rig& rig) {
  std::size_t count = 0;
  for (const Marker& marker : rig.markers) count += marker.fixed ? 1 : 0;
  return count;
}

TEST(RigFiles, StripServesACalibrationFromFilm) {
  const Rig rig = load_rig(shipped("strip.toml"), kCalibrateFromFilm);
  const Box box = rig.bounding_box();
  // 1e-15 m: rounding of the conversion from millimetres.
  EXPECT_TRUE((box.max - box.min).isApprox(Eigen::Vector3d(0.080, 0.010, 0.002), 1e-15));
  EXPECT_EQ(rig.observable->kind, ObservableKind::Displacement);
  EXPECT_EQ(num_fixed(rig), 4U);
  // Every three of them make a triangle higher than a third of the picture's 62 mm.
  EXPECT_GT(spread_of_fixed_markers_m(rig), 0.020);
}

TEST(RigFiles, StripMarkersFitTheFrameAndStayOffTheTipsPath) {
  const Rig rig = load_rig(shipped("strip.toml"), kCalibrateFromFilm);
  const Box frame = {{-0.015, -1.0, -0.030}, {0.095, 1.0, 0.032}};  // 110 x 62 mm
  const Eigen::Vector3d tip = rig.find_marker("tip")->position;
  for (const Marker& marker : rig.markers) {
    EXPECT_TRUE(frame.contains(marker.position, -marker.size_m / 2)) << marker.id;
    if (!marker.fixed) continue;
    const double clearance = std::abs(marker.position.z() - tip.z()) - marker.size_m;
    EXPECT_GT(clearance, 0.008) << marker.id << " stands in the path of the strip";
  }
}

TEST(RigFiles, LRigServesACalibrationFromFilm) {
  const Rig rig = load_rig(shipped("lrig.toml"), kCalibrateFromFilm);
  const Box box = rig.bounding_box();
  EXPECT_TRUE((box.max - box.min).isApprox(Eigen::Vector3d(0.060, 0.024, 0.027), 1e-15));
  EXPECT_EQ(rig.observable->kind, ObservableKind::Angle);
  EXPECT_EQ(num_fixed(rig), 4U);
  EXPECT_GT(spread_of_fixed_markers_m(rig), 0.020);
  const Box part = rig.bounding_box();
  for (const Marker& marker : rig.markers) {
    if (!marker.fixed) continue;
    EXPECT_GT(part.distance(marker.position), marker.size_m / 2)
        << marker.id << " is hidden by the part or touches it";
  }
}

TEST(RigFiles, SiliconeBeamServesACalibrationFromATrace) {
  const Rig rig = load_rig(shipped("silicone_beam.toml"), {.part = true, .clamp = true});
  const Box box = rig.bounding_box();
  EXPECT_TRUE((box.max - box.min).isApprox(Eigen::Vector3d(0.030, 0.030, 0.100), 1e-15));
  EXPECT_EQ(rig.materials.at(0).reported_youngs_modulus_pa, 263.8e3);
  EXPECT_FALSE(rig.gravity_m_s2.has_value());
  EXPECT_THROW((void)load_rig(shipped("silicone_beam.toml"), kCalibrateFromFilm), InputError);
}

TEST(RigFiles, TowerServesTrackingAlone) {
  const Rig rig = load_rig(shipped("knex_tower.toml"), {.film = true, .observable = true});
  EXPECT_EQ(rig.markers.size(), 4U);
  EXPECT_TRUE(rig.find_marker("base")->fixed);
  EXPECT_THROW((void)load_rig(shipped("knex_tower.toml"), {.part = true}), InputError);
}

TEST(RigFiles, WholeTowerHasFourRowsOfSevenDotsTheLowestFixed) {
  const Rig rig = load_rig(shipped("knex_tower_28.toml"), {.film = true, .observable = true});
  ASSERT_EQ(rig.markers.size(), 28U);
  for (std::size_t i = 0; i < 28; ++i) {
    EXPECT_EQ(rig.markers[i].fixed, i < 7) << rig.markers[i].id;
    EXPECT_EQ(rig.markers[i].size_m, rig.markers[0].size_m) << rig.markers[i].id;
    // Rows are about 240 mm apart, one above the other.
    EXPECT_NEAR(rig.markers[i].position.z(), 0.243 * static_cast<double>(i / 7), 0.01);
  }
}

}  // namespace
}  // namespace twang
