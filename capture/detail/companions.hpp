// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/forecast.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// How the moving markers of one rig move together.
///
/// A rig bends in few shapes: when one marker moves, another moves by the same share as before. For
/// each pair the share is a complex number β (a ratio and a turn), by least squares over the recent
/// frames in which both were seen,
///
///     u_i − mean u_i ≈ β (u_j − mean u_j)
///
/// and the residual says how far it is to be trusted. Markers that did not move tell nothing.
class Companions {
 public:
  explicit Companions(std::size_t num_markers);

  /// @param moved_px  from rest, one a marker; nan where it was not seen or is not to count [px]
  void add(const std::vector<Eigen::Vector2d>& moved_px);
  /// How far a marker has gone from rest, by the one among the others that tells most surely;
  /// nothing if none does.
  [[nodiscard]] std::optional<Forecast> predict(std::size_t marker,
                                                const std::vector<Eigen::Vector2d>& moved_px) const;
  /// Whether of the others that could tell to `sure_px` a majority of two or more say that the
  /// marker is elsewhere: off by more than four sigmas and `slack_px`.
  [[nodiscard]] bool contradict(std::size_t marker,
                                const std::vector<Eigen::Vector2d>& moved_px,
                                double slack_px,
                                double sure_px) const;

 private:
  [[nodiscard]] std::optional<Forecast> predict_by(Eigen::Index i,
                                                   Eigen::Index j,
                                                   const Eigen::Vector2d& moved_px) const;
  // Sums over the frames in which both were seen, the older the less.
  Eigen::MatrixXcd m_product;  // of u_i conj(u_j)
  Eigen::MatrixXcd m_sum;      // of u_j
  Eigen::MatrixXd m_square;    // of |u_j|²
  Eigen::MatrixXd m_count;
};

}  // namespace twang::detail
