// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <string>
#include <vector>

namespace twang {

/// By what the columns of `value` are to be divided before their motions are compared: channels of
/// one unit, the suffix of their names, by the largest range among them, for 1 mm is less than 10
/// mm; others each by its own. A column that never changes has 1.
/// @param value  rows: samples, finite; one column a channel
[[nodiscard]] Eigen::RowVectorXd scales_by_unit(const Eigen::MatrixXd& value,
                                                const std::vector<std::string>& names);

/// Each by the noise of its samples at rest, within some parts of its range: where units differ or
/// are not known, motion is what stands out of that.
[[nodiscard]] Eigen::RowVectorXd scales_by_noise(const Eigen::MatrixXd& value);

}  // namespace twang
