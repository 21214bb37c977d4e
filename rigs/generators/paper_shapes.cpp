// SPDX-License-Identifier: GPL-3.0-or-later
#include "rigs/generators/paper_shapes.hpp"

#include "core/constants.hpp"
#include "core/units.hpp"
#include "rigs/solid_shapes.hpp"

#include <cmath>
#include <initializer_list>

namespace twang {
namespace {

constexpr double kDepth_mm = 24.0;
constexpr double kLeaf_mm = 0.6;  // thickness
constexpr double kKnot_mm = 2.7;  // radius
constexpr std::array kLeafHeights_mm = {6.6, 10.8, 15.0, 19.2, 23.4};

/// Outline from corners (x, z) in millimetres.
Eigen::Matrix2Xd outline_mm(const std::vector<std::array<double, 2>>& corners) {
  Eigen::Matrix2Xd outline(2, static_cast<Eigen::Index>(corners.size()));
  Eigen::Index i = 0;
  for (const auto& [x, z] : corners)
    outline.col(i++) = Eigen::Vector2d(x, z) * kMetresPerMillimetre;
  return outline;
}

SurfaceMesh extrude_mm(std::initializer_list<std::array<double, 2>> corners,
                       double from_mm = 0.0,
                       double to_mm = kDepth_mm) {
  return extrude(outline_mm(corners), from_mm * kMetresPerMillimetre, to_mm * kMetresPerMillimetre);
}

/// Points of a curve x(s), s in [0, 1], given in millimetres.
template <typename Curve>
Eigen::Matrix3Xd path_mm(int points, Curve&& curve) {
  Eigen::Matrix3Xd path(3, points);
  for (int i = 0; i < points; ++i) {
    path.col(i) = curve(static_cast<double>(i) / (points - 1)) * kMetresPerMillimetre;
  }
  return path;
}

template <typename Size>
Eigen::VectorXd sizes_mm(int points, Size&& size) {
  Eigen::VectorXd sizes(points);
  for (int i = 0; i < points; ++i) {
    sizes[i] = size(static_cast<double>(i) / (points - 1)) * kMetresPerMillimetre;
  }
  return sizes;
}

/// A flat piece of a leaf from radius `from` to `to` on top of height `z`, as wide as `width` says
/// at so many `points`.
template <typename Width>
SurfaceMesh blade_mm(int points, double from, double to, double z, Width&& width) {
  const auto radius = [&](double s) { return from + (to - from) * s; };
  return ribbon(
      path_mm(points,
              [&](double s) { return Eigen::Vector3d(radius(s), 0.0, z + 0.5 * kLeaf_mm); }),
      sizes_mm(points, [&](double s) { return width(radius(s)); }),
      kLeaf_mm * kMetresPerMillimetre);
}

/// A leaf along x: a petiole, a fold upwards, the blade, a fold downwards and the tip, `tip` from
/// the stem's axis. All of it is as thick as a coarse voxel, and its faces lie between voxels.
SurfaceMesh leaf_mm(double tip, double z, double width_mm) {
  constexpr double kUp = 3.0;
  constexpr double kDown = 1.8;
  const double up = 5.1;
  const double down = tip - 3.6;
  const auto width = [&](double r) {
    const double s = std::max(r - up, 0.0) / (tip - up);
    return 1.8 + (width_mm - 1.8) * std::sin(kPi * std::pow(0.08 + 0.84 * s, 0.8));
  };
  const auto fold = [&](double at, double foot, double top) {
    return extrude_mm({{at - kLeaf_mm, foot}, {at, foot}, {at, top}, {at - kLeaf_mm, top}},
                      -0.5 * width(at),
                      0.5 * width(at));
  };
  const double high = z + kUp;
  const double low = high - kDown;
  return join({blade_mm(2, 1.2, up - kLeaf_mm, z, [](double) { return 1.8; }),
               fold(up, z, high + kLeaf_mm),
               blade_mm(13, up, down - kLeaf_mm, high, width),
               fold(down, low, high + kLeaf_mm),
               blade_mm(5, down, tip, low, width)});
}

/// Turned about z by a quarter so many times.
SurfaceMesh quarter_turns(SurfaceMesh surface, int times) {
  for (int i = 0; i < times; ++i) {
    const Eigen::RowVectorXd x = surface.vertices.row(0);
    surface.vertices.row(0) = -surface.vertices.row(1);
    surface.vertices.row(1) = x;
  }
  return surface;
}

}  // namespace

SurfaceMesh jumper() {
  return extrude_mm({{0, 0},
                     {66, 0},
                     {66, 4.5},
                     {49.5, 4.5},
                     {49.5, 34.5},
                     {1.5, 34.5},
                     {1.5, 25.5},
                     {48, 25.5},
                     {48, 4.5},
                     {0, 4.5}});
}

SurfaceMesh flipper_body() {
  return extrude_mm({{15, 0},
                     {61.5, 0},
                     {61.5, 3},
                     {76.5, 3},
                     {76.5, 4.5},
                     {51, 4.5},
                     {51, 24},
                     {12, 24},
                     {12, 16.5},
                     {49.5, 16.5},
                     {49.5, 4.5},
                     {0, 4.5},
                     {0, 3},
                     {15, 3}});
}

SurfaceMesh flipper_feet() {
  return join({extrude_mm({{7.5, 0}, {15, 0}, {15, 3}, {3, 3}, {3, 1.5}, {7.5, 1.5}}),
               extrude_mm({{61.5, 0}, {69, 0}, {69, 1.5}, {73.5, 1.5}, {73.5, 3}, {61.5, 3}})});
}

SurfaceMesh catapult() {
  return extrude_mm({{7.5, 0},    {69, 0},    {69, 1.5},    {73.5, 1.5}, {73.5, 3},    {76.5, 3},
                     {76.5, 4.5}, {51, 4.5},  {51, 24},     {28.5, 24},  {28.5, 31.5}, {27, 31.5},
                     {27, 24},    {13.5, 24}, {13.5, 31.5}, {12, 31.5},  {12, 16.5},   {49.5, 16.5},
                     {49.5, 4.5}, {0, 4.5},   {0, 3},       {3, 3},      {3, 1.5},     {7.5, 1.5}});
}

SurfaceMesh plant_stem() {
  constexpr int kSides = 24;
  constexpr double kTop = 25.2;
  const auto radius = [](double z) { return 2.4 - 0.6 * z / kTop; };
  std::vector<std::array<double, 2>> profile = {{5.1, 0.0}, {5.1, 1.2}, {radius(2.4), 2.4}};
  for (const double z : kLeafHeights_mm) {  // a knot where leaves begin
    const double foot = z - kLeaf_mm;
    const double top = z + 2.0 * kLeaf_mm;
    profile.insert(profile.end(),
                   {{radius(foot), foot}, {kKnot_mm, foot}, {kKnot_mm, top}, {radius(top), top}});
  }
  profile.push_back({radius(kTop), kTop});
  return revolve(outline_mm(profile), kSides);
}

SurfaceMesh plant_leaves() {
  std::vector<SurfaceMesh> leaves;
  double tip = 21.3;  // each pair is shorter than the one below
  for (std::size_t i = 0; i < kLeafHeights_mm.size(); ++i) {
    for (const int turns : {0, 2}) {
      leaves.push_back(
          quarter_turns(leaf_mm(tip, kLeafHeights_mm[i], 4.8), turns + static_cast<int>(i % 2)));
    }
    tip -= 1.2;
  }
  return join(leaves);
}

std::vector<SurfaceMesh> flamingo() {
  constexpr int kSides = 20;
  constexpr int kPoints = 25;
  const SurfaceMesh leg = revolve(
      outline_mm(
          {{10, 0}, {10, 2.4}, {2.1, 3.6}, {1.5, 9}, {1.5, 24}, {1.9, 26}, {1.5, 28}, {1.8, 48}}),
      kSides);
  const SurfaceMesh body = sweep(
      path_mm(
          kPoints,
          [](double s) { return Eigen::Vector3d(-17 + 32 * s, 0, 48 + 7 * s - 5 * s * (1 - s)); }),
      sizes_mm(kPoints,
               [](double s) { return 0.9 + 7.5 * std::sqrt(std::sin(kPi * (0.04 + 0.92 * s))); }),
      kSides);
  const SurfaceMesh neck = sweep(
      path_mm(2 * kPoints,
              [](double s) {
                const double bend = std::sin(2.0 * kPi * std::min(s / 0.8, 1.0));
                const double over = std::max(s - 0.8, 0.0) / 0.2;  // the head looks down
                return Eigen::Vector3d(
                    12 + 6 * s + 7 * bend + 11 * over, 0, 53 + 40 * s - 8 * over - 8 * over * over);
              }),
      sizes_mm(2 * kPoints,
               [](double s) {
                 const double head = std::exp(-std::pow((s - 0.84) / 0.06, 2));
                 return (s < 0.9 ? 1.9 : 1.9 - 9.0 * (s - 0.9)) + 2.4 * head;
               }),
      kSides);
  return {leg, body, neck};
}

SurfaceMesh walker() {
  // a back that is higher in the middle, 3 mm thick as all of it, and a head
  std::vector<SurfaceMesh> pieces = {extrude_mm({{0, 24},
                                                 {18, 24},
                                                 {18, 27},
                                                 {36, 27},
                                                 {36, 24},
                                                 {54, 24},
                                                 {54, 27},
                                                 {39, 27},
                                                 {39, 30},
                                                 {15, 30},
                                                 {15, 27},
                                                 {0, 27}}),
                                     extrude_mm({{51, 27},
                                                 {54, 27},
                                                 {54, 24},
                                                 {57, 24},
                                                 {60, 27},
                                                 {60, 33},
                                                 {57, 36},
                                                 {54, 36},
                                                 {51, 33}},
                                                6.0,
                                                18.0)};
  for (const double x : {3.0, 45.0}) {  // legs with a knee, on flat soles
    for (const double y : {0.0, 21.0}) {
      pieces.push_back(extrude_mm({{x, 24},
                                   {x, 12},
                                   {x + 3, 12},
                                   {x + 3, 3},
                                   {x, 3},
                                   {x, 0},
                                   {x + 9, 0},
                                   {x + 9, 3},
                                   {x + 6, 3},
                                   {x + 6, 15},
                                   {x + 3, 15},
                                   {x + 3, 24}},
                                  y,
                                  y + 3.0));
    }
  }
  return join(pieces);
}

std::vector<std::pair<std::string, SurfaceMesh>> paper_shapes() {
  const std::vector<SurfaceMesh> bird = flamingo();
  return {{"jumper.stl", jumper()},
          {"flipper_body.stl", flipper_body()},
          {"flipper_feet.stl", flipper_feet()},
          {"catapult.stl", catapult()},
          {"plant_stem.stl", plant_stem()},
          {"plant_leaves.stl", plant_leaves()},
          {"flamingo_leg.stl", bird[0]},
          {"flamingo_body.stl", bird[1]},
          {"flamingo_neck.stl", bird[2]},
          {"walker.stl", walker()}};
}

}  // namespace twang
