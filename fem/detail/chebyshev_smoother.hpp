// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

#include <functional>
#include <vector>

namespace twang {

/// How far a smoothing goes.
struct Smoothing {
  int degree = 3;  ///< of the polynomial: so many products with A
  float range =
      10.0F;  ///< errors with eigenvalues of D^-1 A above the largest over this vanish [-]
};

/// Smoothing of A x = b on one level of a multigrid, in single precision, by Chebyshev polynomials
/// of D^-1 A, D being its 3 x 3 diagonal blocks [Adams, Brezina, Hu, Tuminaro 2003]. Vectors are
/// (3 num_nodes), component by component; held degrees of freedom are 0.
class ChebyshevSmoother {
 public:
  /// y += scale A x.
  using Product = std::function<void(float scale, const float* x, float* y)>;

  explicit ChebyshevSmoother(int num_nodes, Smoothing smoothing = {});
  /// Takes a new A: the blocks of its diagonal, (num_nodes x 6): 00 10 20 11 21 22.
  /// @returns false if one is not positive definite
  [[nodiscard]] bool prepare(const Eigen::ArrayXXd& diagonal_blocks,
                             const std::vector<char>& held,
                             const Product& add_product);
  /// From x and r = b - A x, which is kept up to the last step, or through it where it is wanted.
  void smooth(const Product& add_product, bool residual_wanted);

  [[nodiscard]] double memory_bytes() const { return (6.0 + 9.0) * 4.0 * m_num_nodes; }

  Eigen::VectorXf x, r, step;

 private:
  [[nodiscard]] bool invert_diagonal(const Eigen::ArrayXXd& diagonal,
                                     const std::vector<char>& held);
  void estimate_largest(const std::vector<char>& held, const Product& add_product);
  void precondition_step(float keep, float add);

  int m_num_nodes;
  Smoothing m_smoothing;
  Eigen::ArrayXXf m_inverse_diagonal;  ///< (num_nodes x 6): 00 10 20 11 21 22
  float m_largest = 1.0F;              ///< estimated largest eigenvalue of D^-1 A
};

}  // namespace twang
