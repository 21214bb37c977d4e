// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/plane_fit.hpp"

#include "core/dense_algebra.hpp"
#include "core/error.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Points = std::vector<Eigen::Vector2d>;
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Matrix8d = Eigen::Matrix<double, 8, 8>;
using Matrix28d = Eigen::Matrix<double, 2, 8>;

constexpr int kMostIterations = 20;
// Smallest over largest singular value of points that still span a plane.
constexpr double kLeastSpread = 1e-3;
// Of known positions, from which slant and perspective are to be read all over the plane.
constexpr double kLeastAcross = 0.05;

double weight_of(const PointPairs& pairs, std::size_t i) {
  return pairs.sigma.empty() ? 1.0 : 1.0 / (pairs.sigma[i] * pairs.sigma[i]);
}

Eigen::Vector2d weighted_mean(const PointPairs& pairs, const Points& points) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double weights = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    sum += weight_of(pairs, i) * points[i];
    weights += weight_of(pairs, i);
  }
  return sum / weights;
}

/// Moves the mean to the origin and the rms distance to sqrt(2).
Homography normalisation(const Points& points) {
  const Eigen::Vector2d mean = weighted_mean({}, points);
  double square = 0.0;
  for (const auto& point : points) square += (point - mean).squaredNorm();
  const double scale = std::sqrt(2.0 * static_cast<double>(points.size()) / square);
  Homography map;
  map << scale, 0.0, -scale * mean.x(), 0.0, scale, -scale * mean.y(), 0.0, 0.0, 1.0;
  return map;
}

/// The direct linear transform: the vector that the two rows per point leave smallest.
Homography direct_linear_transform(const PointPairs& pairs) {
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(9, 9);
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    Eigen::Matrix<double, 2, 9> rows = Eigen::Matrix<double, 2, 9>::Zero();
    const Eigen::RowVector3d p = pairs.from[i].homogeneous().transpose();
    rows.block<1, 3>(0, 0) = p;
    rows.block<1, 3>(1, 3) = p;
    rows.block<2, 3>(0, 6) = -pairs.to[i] * p;
    normal.noalias() += rows.transpose() * rows;
  }
  // Squares of the singular values, ascending.
  const SymmetricEigen eigen = symmetric_eigen(normal);
  if (!(eigen.values[1] > kLeastSpread * kLeastSpread * eigen.values[8])) {
    throw InputError(
        "the fixed markers leave the plane's map undetermined, no three of four may be on a line");
  }
  const Eigen::VectorXd h = eigen.vectors.col(0);
  Homography map;
  map << h[0], h[1], h[2], h[3], h[4], h[5], h[6], h[7], h[8];
  return map / map(2, 2);
}

/// Derivative of a mapped point by the map's first eight entries, the last being one.
Matrix28d entries_jacobian(const Homography& map, const Eigen::Vector2d& point) {
  const Eigen::RowVector3d p = point.homogeneous().transpose();
  const double w = map.row(2).dot(p);
  Matrix28d J = Matrix28d::Zero();
  J.block<1, 3>(0, 0) = p / w;
  J.block<1, 3>(1, 3) = p / w;
  J.block<2, 2>(0, 6) = -map_point(map, point) * p.head<2>() / w;
  return J;
}

/// Gauss-Newton on the distances in `to`, the last entry held at one.
Homography refine(Homography map, const PointPairs& pairs) {
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    Matrix8d normal = Matrix8d::Zero();
    Vector8d gradient = Vector8d::Zero();
    for (std::size_t i = 0; i < pairs.from.size(); ++i) {
      const Matrix28d J = entries_jacobian(map, pairs.from[i]);
      const double weight = weight_of(pairs, i);
      normal += J.transpose().lazyProduct(weight * J);
      gradient += weight * J.transpose() * (pairs.to[i] - map_point(map, pairs.from[i]));
    }
    const Vector8d step = solve_symmetric(normal, gradient);
    if (!step.allFinite()) break;
    map.row(0) += step.segment<3>(0).transpose();
    map.row(1) += step.segment<3>(3).transpose();
    map.block<1, 2>(2, 0) += step.segment<2>(6).transpose();
    if (step.norm() < 1e-14 * map.norm()) break;
  }
  return map;
}

Homography fit_shift(const PointPairs& pairs) {
  Homography map = Homography::Identity();
  map.topRightCorner<2, 1>() = weighted_mean(pairs, pairs.to) - weighted_mean(pairs, pairs.from);
  return map;
}

/// Derivative of the eight entries by the parameters of a kind of map, in centred coordinates.
Eigen::MatrixXd entries_by_parameters(MapKind kind) {
  if (kind == MapKind::Projective) return Matrix8d::Identity();
  const int count = num_parameters(kind);
  Eigen::MatrixXd G = Eigen::MatrixXd::Zero(8, count);
  G(2, 0) = G(5, 1) = 1.0;  // shift
  if (kind == MapKind::Similarity) {
    G(0, 2) = G(4, 2) = 1.0;  // stretch
    G(3, 3) = 1.0;            // turn
    G(1, 3) = -1.0;
  }
  return G;
}

}  // namespace

Eigen::Vector2d map_point(const Homography& map, const Eigen::Vector2d& point) {
  return (map * point.homogeneous()).hnormalized();
}

Eigen::Matrix2d map_jacobian(const Homography& map, const Eigen::Vector2d& point) {
  const double w = map.row(2).dot(point.homogeneous());
  return (map.topLeftCorner<2, 2>() - map_point(map, point) * map.block<1, 2>(2, 0)) / w;
}

Homography fit_similarity_map(const PointPairs& pairs) {
  const Eigen::Vector2d from = weighted_mean(pairs, pairs.from);
  const Eigen::Vector2d to = weighted_mean(pairs, pairs.to);
  double along = 0.0;
  double across = 0.0;
  double square = 0.0;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    const Eigen::Vector2d a = pairs.from[i] - from;
    const Eigen::Vector2d b = pairs.to[i] - to;
    along += weight_of(pairs, i) * a.dot(b);
    across += weight_of(pairs, i) * (a.x() * b.y() - a.y() * b.x());
    square += weight_of(pairs, i) * a.squaredNorm();
  }
  Eigen::Matrix2d turn;
  turn << along, -across, across, along;
  turn /= square;
  Homography map = Homography::Identity();
  map.topLeftCorner<2, 2>() = turn;
  map.topRightCorner<2, 1>() = to - turn * from;
  return map;
}

Homography fit_homography(const PointPairs& pairs) {
  const Homography from = normalisation(pairs.from);
  const Homography to = normalisation(pairs.to);
  PointPairs normal;
  normal.sigma = pairs.sigma;
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    normal.from.push_back(map_point(from, pairs.from[i]));
    normal.to.push_back(map_point(to, pairs.to[i]));
  }
  const Homography map = refine(direct_linear_transform(normal), normal);
  const Homography result = to.inverse() * map * from;
  return result / result(2, 2);
}

bool span_plane(const Points& points) {
  if (points.size() < 4) return false;
  const Eigen::Vector2d mean = weighted_mean({}, points);
  Eigen::Matrix2d moments = Eigen::Matrix2d::Zero();
  for (const Eigen::Vector2d& point : points) {
    moments += (point - mean) * (point - mean).transpose();
  }
  const Eigen::VectorXd spread = symmetric_eigen(moments).values;
  return spread[0] > kLeastAcross * kLeastAcross * spread[1];
}

int num_parameters(MapKind kind) {
  return kind == MapKind::Shift ? 2 : kind == MapKind::Similarity ? 4 : 8;
}

MapFit fit_map(MapKind kind, const PointPairs& pairs) {
  MapFit fit;
  fit.map = kind == MapKind::Shift        ? fit_shift(pairs)
            : kind == MapKind::Similarity ? fit_similarity_map(pairs)
                                          : fit_homography(pairs);
  fit.centre = weighted_mean(pairs, pairs.from);
  double square = 0.0;
  for (const auto& point : pairs.from) square += (point - fit.centre).squaredNorm();
  if (square > 0.0) fit.scale = std::sqrt(static_cast<double>(pairs.from.size()) / square);

  const Homography centred = fit.centred();
  const Eigen::MatrixXd G = entries_by_parameters(kind);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(G.cols(), G.cols());
  for (std::size_t i = 0; i < pairs.from.size(); ++i) {
    const Eigen::MatrixXd J =
        entries_jacobian(centred, (pairs.from[i] - fit.centre) * fit.scale).lazyProduct(G);
    normal += J.transpose().lazyProduct(weight_of(pairs, i) * J);
  }
  fit.covariance = G.lazyProduct(solve_symmetric(normal, G.transpose()));
  return fit;
}

Homography MapFit::centred() const {
  Homography from_centred = Homography::Identity();
  from_centred.topLeftCorner<2, 2>() /= scale;
  from_centred.topRightCorner<2, 1>() = centre;
  const Homography result = map * from_centred;
  return result / result(2, 2);
}

Eigen::Matrix2d MapFit::covariance_at(const Eigen::Vector2d& point) const {
  const Matrix28d J = entries_jacobian(centred(), (point - centre) * scale);
  const Matrix28d spread = J.lazyProduct(covariance);
  return spread.lazyProduct(J.transpose());
}

double MapFit::log_scale_variance_at(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d at = (point - centre) * scale;
  const auto log_scale = [&](const Homography& h) {
    return 0.5 * std::log(std::abs(map_jacobian(h, at).determinant()));
  };
  constexpr double kStep = 1e-5;  // of the map's own size: central differences good to 1e-10
  const Homography map_here = centred();
  const double size = map_here.topLeftCorner<2, 2>().norm();
  Vector8d gradient;
  for (int k = 0; k < 8; ++k) {
    const double step = kStep * (k < 6 ? size : 1.0);
    Homography more = map_here;
    Homography less = map_here;
    more(k / 3, k % 3) += step;
    less(k / 3, k % 3) -= step;
    gradient[k] = (log_scale(more) - log_scale(less)) / (2.0 * step);
  }
  return gradient.dot(covariance * gradient);
}

}  // namespace twang
