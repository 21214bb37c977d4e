// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

namespace twang::detail {

/// Cauchy stress at the elements' middles, (6 x num_elements): xx yy zz xy yz xz [Pa], turned by
/// `rotation`. Internal modes of an element are zero there.
[[nodiscard]] Eigen::MatrixXd cell_stress(const ElasticBody& body,
                                          const Eigen::VectorXd& u,
                                          const Eigen::Matrix3d& rotation);

/// sqrt(3/2 s : s) with s the deviator, of each column of `stress` [Pa].
[[nodiscard]] Eigen::VectorXd von_mises(const Eigen::MatrixXd& stress);

}  // namespace twang::detail
