// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>
#include <cholmod.h>

#include <vector>

namespace twang {

/// The values of a supernodal Cholesky factor in single precision, for solves of about six digits:
/// a preconditioner needs no more, and going through half the memory takes half the time.
///
/// A supernode is a block of columns with one pattern: a lower triangle on top of a rectangle,
/// whole rows of which lie below [Davis, Rajamanickam & Sid-Lakhdar 2016, section 9].
template <class Index>
class SingleFactor {
 public:
  /// Copies the values; the pattern is that of `factor` and must outlive this.
  explicit SingleFactor(const cholmod_factor& factor);

  /// x ~ A^-1 b, both in the order of A's columns.
  /// @param x  may be b
  void solve(const Eigen::VectorXd& b, Eigen::VectorXd& x);

 private:
  struct Supernode {
    Index first_column;
    int num_columns;
    int num_rows;  ///< of all: the columns' own and those below
    const Index* rows;
    const float* values;  ///< num_rows x num_columns
  };
  [[nodiscard]] Supernode supernode(std::size_t s) const;
  void forward(const Supernode& node);
  void backward(const Supernode& node);

  const cholmod_factor* m_factor;
  std::vector<float> m_values;
  Eigen::VectorXf m_x;      ///< in the order of the factor's columns
  Eigen::VectorXf m_below;  ///< of the rows below a supernode
};

}  // namespace twang
