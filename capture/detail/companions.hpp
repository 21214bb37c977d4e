// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "capture/detail/forecast.hpp"

#include <Eigen/Core>

#include <optional>
#include <vector>

namespace twang::detail {

/// How the moving markers of one rig move together.
///
/// A rig bends in few shapes: where one marker has gone, another has gone by the same share as
/// before. For each pair the share is a complex number β (a ratio and a turn), u_i ≈ β u_j, by least
/// squares over the recent frames in which both were seen; its residual says how far it is to be
/// trusted.
class Companions {
 public:
  explicit Companions(std::size_t num_markers);

  /// @param moved_px  from rest, one a marker; nan where it was not seen or is not to count [px]
  void add(const std::vector<Eigen::Vector2d>& moved_px);
  /// How far a marker has gone from rest, by the one among the others that tells most surely;
  /// nothing if none does.
  [[nodiscard]] std::optional<Forecast> predict(std::size_t marker,
                                                const std::vector<Eigen::Vector2d>& moved_px) const;

 private:
  Eigen::MatrixXcd m_product;  // sum of u_i conj(u_j)
  Eigen::MatrixXd m_square;    // sum of |u_j|² where both were seen
  Eigen::MatrixXd m_count;
};

}  // namespace twang::detail
