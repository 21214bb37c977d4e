// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/layout_map.hpp"

#include <Eigen/Cholesky>

#include <cmath>
#include <complex>

namespace twang::detail {
namespace {

using Complex = std::complex<double>;
using Vector8d = Eigen::Matrix<double, 8, 1>;

constexpr double kSigmaSlant = 0.08;        // of the two axes' scales against each other
constexpr double kSigmaPerspective = 0.15;  // change of scale over the layout's extent
constexpr int kIterations = 4;              // of Gauss-Newton; the map is nearly linear

Complex complex(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }

}  // namespace

Homography fit_weighted_similarity(const std::vector<LayoutPair>& pairs) {
  double total = 0.0;
  Complex plane = 0.0;
  Complex px = 0.0;
  for (const LayoutPair& pair : pairs) {
    const double weight = 1.0 / (pair.sigma_px * pair.sigma_px);
    total += weight;
    plane += weight * complex(pair.plane);
    px += weight * complex(pair.px);
  }
  plane /= total;
  px /= total;
  Complex product = 0.0;
  double square = 0.0;
  for (const LayoutPair& pair : pairs) {
    const double weight = 1.0 / (pair.sigma_px * pair.sigma_px);
    product += weight * std::conj(complex(pair.plane) - plane) * (complex(pair.px) - px);
    square += weight * std::norm(complex(pair.plane) - plane);
  }
  const Complex scale = product / square;
  const Complex shift = px - scale * plane;
  Homography map;
  map << scale.real(), -scale.imag(), shift.real(), scale.imag(), scale.real(), shift.imag(), 0.0,
      0.0, 1.0;
  return map;
}

/// In coordinates s = (plane − middle) / extent the map is (B s + t) / (1 + g s); of B the two
/// combinations that no similarity has, and g, are held to zero.
Homography fit_layout_map(const std::vector<LayoutPair>& pairs, double extent_m) {
  const Homography similarity = fit_weighted_similarity(pairs);
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const LayoutPair& pair : pairs) middle += pair.plane / static_cast<double>(pairs.size());
  const double scale_px = extent_m * similarity.col(0).norm();
  Eigen::Matrix2d b = extent_m * similarity.topLeftCorner<2, 2>();
  Eigen::Vector2d t = map_point(similarity, middle);
  Eigen::Vector2d g = Eigen::Vector2d::Zero();
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    Eigen::Matrix<double, 8, 8> normal = Eigen::Matrix<double, 8, 8>::Zero();
    Vector8d gradient = Vector8d::Zero();
    const auto add = [&](const Vector8d& row, double difference, double sigma) {
      normal += row * row.transpose() / (sigma * sigma);
      gradient += row * (difference / (sigma * sigma));
    };
    for (const LayoutPair& pair : pairs) {
      const Eigen::Vector2d s = (pair.plane - middle) / extent_m;
      const double depth = 1.0 + g.dot(s);
      const Eigen::Vector2d at = (b * s + t) / depth;
      for (int axis = 0; axis < 2; ++axis) {
        Vector8d row = Vector8d::Zero();
        row.segment<2>(2 * axis) = s / depth;
        row[4 + axis] = 1.0 / depth;
        row.tail<2>() = -at[axis] * s / depth;
        add(row, pair.px[axis] - at[axis], pair.sigma_px);
      }
    }
    Vector8d stretch = Vector8d::Zero();
    stretch[0] = 1.0;
    stretch[3] = -1.0;
    add(stretch, b(1, 1) - b(0, 0), kSigmaSlant * scale_px);
    Vector8d shear = Vector8d::Zero();
    shear[1] = 1.0;
    shear[2] = 1.0;
    add(shear, -b(0, 1) - b(1, 0), kSigmaSlant * scale_px);
    add(Vector8d::Unit(6), -g.x(), kSigmaPerspective);
    add(Vector8d::Unit(7), -g.y(), kSigmaPerspective);
    const Vector8d step = normal.ldlt().solve(gradient);
    b.row(0) += step.segment<2>(0).transpose();
    b.row(1) += step.segment<2>(2).transpose();
    t += step.segment<2>(4);
    g += step.tail<2>();
  }
  Homography map;
  map << b(0, 0), b(0, 1), t.x(), b(1, 0), b(1, 1), t.y(), g.x(), g.y(), 1.0;
  Homography local;
  local << 1.0 / extent_m, 0.0, -middle.x() / extent_m, 0.0, 1.0 / extent_m, -middle.y() / extent_m,
      0.0, 0.0, 1.0;
  return map * local;
}

}  // namespace twang::detail
