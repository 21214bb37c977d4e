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

/// Outline from corners (x, z) in millimetres.
Eigen::Matrix2Xd outline_mm(std::initializer_list<std::array<double, 2>> corners) {
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

/// A leaf that leaves the stem at height `z` and arches over.
SurfaceMesh leaf(double z, double azimuth) {
  constexpr int kPoints = 25;
  constexpr double kLength = 24.0;
  const auto curve = [&](double s) {
    const double r = 0.6 + kLength * s;
    const double height = z + 9.0 * s - 8.0 * s * s;
    return Eigen::Vector3d(r * std::cos(azimuth), r * std::sin(azimuth), height);
  };
  const auto width = [](double s) { return 1.8 + 5.4 * std::sin(kPi * std::pow(s, 0.8)); };
  return ribbon(path_mm(kPoints, curve), sizes_mm(kPoints, width), 0.9 * kMetresPerMillimetre);
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
  return revolve(
      outline_mm({{6, 0}, {6, 1.8}, {1.8, 2.4}, {1.4, 6}, {1.2, 20}, {1.1, 40}, {0.8, 46}}),
      kSides);
}

SurfaceMesh plant_leaves() {
  return join({leaf(18.0, 0.0), leaf(24.0, 0.5 * kPi), leaf(21.0, kPi), leaf(30.0, 1.5 * kPi)});
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
  std::vector<SurfaceMesh> pieces = {
      extrude_mm({{0, 24}, {48, 24}, {48, 36}, {42, 42}, {6, 42}, {0, 36}})};
  for (const double x : {3.0, 36.0}) {
    for (const double y : {0.0, 18.0}) {
      pieces.push_back(extrude_mm({{x, 24},
                                   {x, 6},
                                   {x + 0.6, 3},
                                   {x + 1.8, 1.2},
                                   {x + 4.5, 0},
                                   {x + 7.5, 1.2},
                                   {x + 9, 3},
                                   {x + 9, 4.5},
                                   {x + 4.5, 6},
                                   {x + 4.5, 24}},
                                  y,
                                  y + 6.0));
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
