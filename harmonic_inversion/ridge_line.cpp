// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/ridge_line.hpp"

#include <algorithm>
#include <cmath>

namespace twang {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A line, its slope's weights on y, and the weighted squares that it leaves.
struct WeightedLine {
  RidgeLine line;
  VectorXd centred;
  VectorXd q;
  double squares = 0.0;
};

WeightedLine through(const VectorXd& x, const VectorXd& y, const VectorXd& weight) {
  WeightedLine out;
  RidgeLine& line = out.line;
  line.mean_x = weight.dot(x) / weight.sum();
  line.mean = weight.dot(y) / weight.sum();
  out.centred = x.array() - line.mean_x;
  out.q = weight.cwiseProduct(out.centred);
  out.q /= out.q.dot(out.centred);
  line.slope = out.q.dot(y);
  const VectorXd rest = y.array() - line.mean - line.slope * out.centred.array();
  out.squares = weight.dot(rest.cwiseAbs2());
  return out;
}

double excess(double squares, double expected) {
  return expected > 0.0 ? std::max(1.0, squares / expected) : 1.0;
}

}  // namespace

RidgeLine fit_ridge_line(const VectorXd& x, const VectorXd& y, const MatrixXd& covariance) {
  const VectorXd weight = covariance.diagonal().cwiseInverse();
  WeightedLine found = through(x, y, weight);
  const MatrixXd keeps = MatrixXd::Identity(x.size(), x.size()) -
                         VectorXd::Ones(x.size()) * (weight / weight.sum()).transpose() -
                         found.centred * found.q.transpose();
  const double expected = weight.dot((keeps * covariance).cwiseProduct(keeps).rowwise().sum());
  found.line.slope_sigma =
      std::sqrt(found.q.dot(covariance * found.q) * excess(found.squares, expected));
  return found.line;
}

RidgeLine fit_ridge_line_through_independent(const VectorXd& x,
                                             const VectorXd& y,
                                             const VectorXd& variance) {
  WeightedLine found = through(x, y, variance.cwiseInverse());
  // As many squares are expected as points are left over after mean and slope.
  const double expected = static_cast<double>(x.size()) - 2.0;
  found.line.slope_sigma =
      std::sqrt(variance.dot(found.q.cwiseAbs2()) * excess(found.squares, expected));
  return found.line;
}

}  // namespace twang
