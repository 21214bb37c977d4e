// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/lens.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <Eigen/Dense>
#include <fmt/format.h>

#include <cmath>

namespace twang {
namespace {

constexpr int kMostIterations = 50;
constexpr int kMostHalvings = 12;
// Where Newton's steps end, and what must then be left at most: parts of the focal length.
constexpr double kConverged = 1e-15;
constexpr double kSolved = 1e-12;
constexpr double kOnAxis = 1e-8;  // radius below which a fisheye is a pinhole, to 1e-16

/// A point and how it moves with the one it comes from.
struct Bent {
  Eigen::Vector2d at;
  Eigen::Matrix2d jacobian;
};

/// The projection onto a sensor that is turned by (τx, τy).
Eigen::Matrix3d tilted_sensor(double tau_x, double tau_y) {
  Eigen::Matrix3d about_x;
  about_x << 1.0, 0.0, 0.0, 0.0, std::cos(tau_x), std::sin(tau_x), 0.0, -std::sin(tau_x),
      std::cos(tau_x);
  Eigen::Matrix3d about_y;
  about_y << std::cos(tau_y), 0.0, -std::sin(tau_y), 0.0, 1.0, 0.0, std::sin(tau_y), 0.0,
      std::cos(tau_y);
  const Eigen::Matrix3d R = about_y * about_x;
  Eigen::Matrix3d along_axis = Eigen::Matrix3d::Identity();
  along_axis(0, 0) = along_axis(1, 1) = R(2, 2);
  along_axis(0, 2) = -R(0, 2);
  along_axis(1, 2) = -R(1, 2);
  return along_axis * R;
}

Bent bend_polynomial(const std::array<double, 14>& k, const Eigen::Vector2d& p) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tau_x, tau_y] = k;
  const double x = p.x();
  const double y = p.y();
  const double r2 = p.squaredNorm();
  const double above = 1.0 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const double below = 1.0 + r2 * (k4 + r2 * (k5 + r2 * k6));
  const double above_rate = k1 + r2 * (2.0 * k2 + r2 * 3.0 * k3);  // by r²
  const double below_rate = k4 + r2 * (2.0 * k5 + r2 * 3.0 * k6);
  const double g = above / below;
  const double g_rate = (above_rate - g * below_rate) / below;
  Bent bent;
  bent.at.x() = g * x + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (s1 + s2 * r2);
  bent.at.y() = g * y + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (s3 + s4 * r2);
  Eigen::Matrix2d& J = bent.jacobian;
  J = g * Eigen::Matrix2d::Identity() + 2.0 * g_rate * p * p.transpose();
  J(0, 0) += 2.0 * p1 * y + 6.0 * p2 * x;
  J(0, 1) += 2.0 * p1 * x + 2.0 * p2 * y;
  J(1, 0) += 2.0 * p1 * x + 2.0 * p2 * y;
  J(1, 1) += 6.0 * p1 * y + 2.0 * p2 * x;
  J.row(0) += 2.0 * (s1 + 2.0 * s2 * r2) * p.transpose();
  J.row(1) += 2.0 * (s3 + 2.0 * s4 * r2) * p.transpose();
  if (tau_x == 0.0 && tau_y == 0.0) return bent;
  const Eigen::Matrix3d sensor = tilted_sensor(tau_x, tau_y);
  const Eigen::Vector3d on_sensor = sensor * bent.at.homogeneous();
  const Eigen::Vector2d at = on_sensor.hnormalized();
  const Eigen::Matrix2d turn =
      (sensor.topLeftCorner<2, 2>() - at * sensor.block<1, 2>(2, 0)) / on_sensor.z();
  return {at, turn * bent.jacobian};
}

Bent bend_fisheye(const std::array<double, 14>& k, const Eigen::Vector2d& p) {
  const double r = p.norm();
  if (r < kOnAxis) return {p, Eigen::Matrix2d::Identity()};
  const double theta = std::atan(r);
  const double t2 = theta * theta;
  const double bent_theta = theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double rate =
      1.0 + t2 * (3.0 * k[0] + t2 * (5.0 * k[1] + t2 * (7.0 * k[2] + t2 * 9.0 * k[3])));
  const double g = bent_theta / r;
  const double g_rate = (rate / (1.0 + r * r) - g) / r;  // dg / dr
  const Eigen::Vector2d outwards = p / r;
  return {g * p, g * Eigen::Matrix2d::Identity() + g_rate * r * outwards * outwards.transpose()};
}

Bent bend(const Lens& lens, const Eigen::Vector2d& p) {
  return lens.model == LensModel::Fisheye ? bend_fisheye(lens.coefficients, p)
                                          : bend_polynomial(lens.coefficients, p);
}

Eigen::Vector2d on_axes(const Lens& lens, const Eigen::Vector2d& px) {
  return (px - lens.centre_px).cwiseQuotient(lens.focal_px);
}

}  // namespace

Eigen::Vector2d Lens::distorted(const Eigen::Vector2d& ideal) const {
  return bend(*this, on_axes(*this, ideal)).at.cwiseProduct(focal_px) + centre_px;
}

Eigen::Matrix2d Lens::distortion_jacobian(const Eigen::Vector2d& ideal) const {
  return focal_px.asDiagonal() * bend(*this, on_axes(*this, ideal)).jacobian *
         focal_px.cwiseInverse().asDiagonal();
}

Eigen::Vector2d Lens::undistorted(const Eigen::Vector2d& seen) const {
  const Eigen::Vector2d nowhere = Eigen::Vector2d::Constant(kNaN);
  if (!seen.allFinite()) return nowhere;
  const Eigen::Vector2d target = on_axes(*this, seen);
  // From the axis outwards nothing folds: the way there is shortened where a step leads astray.
  Eigen::Vector2d p = Eigen::Vector2d::Zero();
  Bent bent = bend(*this, p);
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const Eigen::Vector2d off = target - bent.at;
    if (off.norm() < kConverged * (1.0 + target.norm())) break;
    if (!(bent.jacobian.determinant() > 0.0)) return nowhere;
    const Eigen::Vector2d step = bent.jacobian.inverse() * off;
    double part = 1.0;
    Bent next = bend(*this, p + step);
    for (int halving = 0; halving < kMostHalvings; ++halving) {
      if (next.jacobian.determinant() > 0.0 && (target - next.at).norm() < off.norm()) break;
      part *= 0.5;
      next = bend(*this, p + part * step);
    }
    if (!((target - next.at).norm() < off.norm())) break;  // round-off, or a fold
    p += part * step;
    bent = next;
  }
  const bool solved = (target - bent.at).norm() < kSolved && bent.jacobian.determinant() > 0.0;
  if (!solved) return nowhere;
  return p.cwiseProduct(focal_px) + centre_px;
}

Lens lens_for_size(const Lens& lens, int width_px, int height_px) {
  // Half a pixel of rounding in either side is no other proportion.
  const double across = static_cast<double>(width_px) * lens.height_px;
  const double down = static_cast<double>(height_px) * lens.width_px;
  if (std::abs(across - down) > std::max(lens.width_px, lens.height_px)) {
    throw InputError(
        fmt::format("the camera file is for pictures of {} x {} px, but the film's are {} x {} px, "
                    "must be of one proportion, upright as the film is shown and not cropped",
                    lens.width_px,
                    lens.height_px,
                    width_px,
                    height_px));
  }
  Lens scaled = lens;
  const Eigen::Vector2d scale(static_cast<double>(width_px) / lens.width_px,
                              static_cast<double>(height_px) / lens.height_px);
  scaled.width_px = width_px;
  scaled.height_px = height_px;
  scaled.focal_px = lens.focal_px.cwiseProduct(scale);
  // Pictures begin half a pixel before the centre of their first pixel.
  scaled.centre_px = (lens.centre_px.array() + 0.5) * scale.array() - 0.5;
  return scaled;
}

}  // namespace twang
