// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "fem/elastic_body.hpp"

#include <Eigen/Core>

#include <vector>

namespace twang::detail {

/// A body with held nodes as a time step sees it: forces, mass and the matrix of an implicit step.
/// All vectors are (3 num_nodes); what it returns is 0 at held nodes.
class DampedBody {
 public:
  /// Keeps a reference to `body`, and its mass as it is now.
  /// @throws InputError if a held node does not exist or the materials differ in a
  DampedBody(const ElasticBody& body, const std::vector<int>& held_nodes);

  [[nodiscard]] const ElasticBody& body() const { return m_body; }
  [[nodiscard]] const FreeDofs& free() const { return m_free; }
  [[nodiscard]] bool held() const { return !m_held_nodes.empty(); }
  [[nodiscard]] const std::vector<int>& held_nodes() const { return m_held_nodes; }

  /// M w [N if w is an acceleration].
  [[nodiscard]] Eigen::VectorXd mass_product(const Eigen::VectorXd& w) const;
  /// f_int(u) + D(u) v,  D = a M + sum of b_e K_e [N]; not finite if an element is inside out.
  [[nodiscard]] Eigen::VectorXd resisting_force(const Eigen::VectorXd& u,
                                                const Eigen::VectorXd& v) const;

  /// D(u) v, held nodes included [N].
  [[nodiscard]] Eigen::VectorXd damping_force(const Eigen::VectorXd& u,
                                              const Eigen::VectorXd& v) const;
  /// M w, held nodes included.
  [[nodiscard]] Eigen::VectorXd full_mass_product(const Eigen::VectorXd& w) const;

  /// Where and how fast the body is in a step that is being solved, and how the step weighs
  /// inertia (mu) and velocity (gamma): v = gamma δ + const.
  struct Linearization {
    Eigen::VectorXd u;         // [m]
    Eigen::VectorXd v;         // [m/s]
    double mu_per_s2 = 0.0;    // [1/s²]
    double gamma_per_s = 0.0;  // 0: at rest, without damping [1/s]
    bool differences = false;  // derivative of D by differences, not by a K taken ahead
  };
  /// Derivative by δ of  mu M δ + f_int(u + δ) + D(u + δ) (v + gamma δ),  applied to w [N]:
  ///
  ///     (mu + gamma a) M w + K(u) w + gamma sum of b_e K_e(u + v / gamma) w
  ///
  /// Taking K_e a little ahead, at u + v / gamma, is the derivative of D to second order: the third
  /// derivative of the energy is symmetric, dK[w] v = dK[v] w. With one b for all materials both K
  /// are merged into (1 + gamma b) K(u + b v / (1 + gamma b)), again to second order. That costs
  /// nothing, but in fast motion it is not good enough; `differences` makes it exact to 1e-6 at
  /// thrice the price.
  [[nodiscard]] Eigen::VectorXd step_product(const Linearization& at,
                                             const Eigen::VectorXd& w) const;
  /// The same as a matrix over the free degrees of freedom, without the derivative of D if
  /// `differences` is set [N/m].
  [[nodiscard]] SparseMatrix step_matrix(const Linearization& at) const;
  /// Whether it is damped by b K of a material whose volume is so much stiffer than its shape that
  /// K taken ahead is no derivative of D.
  [[nodiscard]] bool stiff_in_volume() const { return m_stiff_in_volume; }
  /// What M is multiplied by in it, mu + gamma a [1/s²].
  [[nodiscard]] double inertia_weight(const Linearization& at) const {
    return at.mu_per_s2 + at.gamma_per_s * m_a;
  }
  /// The diagonal of its part in M, free degrees of freedom [N/m].
  [[nodiscard]] Eigen::VectorXd inertia_diagonal(const Linearization& at) const;

 private:
  void clear_held(Eigen::VectorXd& w) const;

  const ElasticBody& m_body;
  std::vector<int> m_held_nodes;
  FreeDofs m_free;
  Eigen::SparseMatrix<double> m_nodal_mass;  // M = nodal mass ⊗ I [kg]
  double m_a = 0.0;                          // [1/s]
  double m_b = 0.0;                          // largest b [s]
  bool m_stiff_in_volume = false;
  bool m_one_b = true;  // whether all materials share it
};

}  // namespace twang::detail
