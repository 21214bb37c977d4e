// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/quadratic_problem.hpp"

#include "fem/detail/chebyshev_smoother.hpp"
#include "fem/detail/multigrid.hpp"
#include "fem/detail/quadratic_cells.hpp"
#include "fem/detail/voxel_body.hpp"
#include "fem/hex_edges.hpp"

#include <array>
#include <cstddef>
#include <utility>

namespace twang {
namespace {

/// How far from the middle of its edge a node may lie [lengths of the edge].
constexpr double kOffMiddle = 1e-5;

/// The hex8 of the same cells, and where their nodes stand among the hex20's.
struct LinearMesh {
  HexMesh mesh;
  std::vector<int> node_of;  ///< of the quadratic mesh, for each
};

LinearMesh linear_mesh(const HexMesh& quadratic) {
  LinearMesh linear;
  linear.mesh = quadratic;
  linear.mesh.kind = ElementKind::Hex8;
  linear.mesh.elements = quadratic.elements.topRows(8);
  std::vector<int> corner_of(static_cast<std::size_t>(quadratic.num_nodes()), -1);
  for (int& node : linear.mesh.elements.reshaped()) {
    int& corner = corner_of[static_cast<std::size_t>(node)];
    if (corner < 0) {
      corner = static_cast<int>(linear.node_of.size());
      linear.node_of.push_back(node);
    }
    node = corner;
  }
  linear.mesh.nodes = quadratic.nodes(Eigen::all, linear.node_of);
  return linear;
}

FreeDofs linear_free(const LinearMesh& linear, const FreeDofs& free, int num_nodes) {
  std::vector<char> held(static_cast<std::size_t>(3 * num_nodes), 0);
  for (const int dof : free.held_dofs()) held[static_cast<std::size_t>(dof)] = 1;
  std::vector<int> dofs;
  for (std::size_t n = 0; n < linear.node_of.size(); ++n) {
    for (int a = 0; a < 3; ++a) {
      const auto at = static_cast<std::size_t>(3 * linear.node_of[n] + a);
      if (held[at] != 0) dofs.push_back(3 * static_cast<int>(n) + a);
    }
  }
  return FreeDofs::from_held_dofs(static_cast<int>(linear.node_of.size()), dofs);
}

/// From linear functions to quadratic ones: corners keep their value, the middle of an edge has the
/// mean of its ends'.
class Interpolation {
 public:
  Interpolation(const HexMesh& quadratic, std::vector<int> node_of)
      : m_node_of(std::move(node_of)), m_num_nodes(quadratic.num_nodes()) {
    std::vector<int> linear_of(static_cast<std::size_t>(m_num_nodes), -1);
    for (std::size_t n = 0; n < m_node_of.size(); ++n) {
      linear_of[static_cast<std::size_t>(m_node_of[n])] = static_cast<int>(n);
    }
    std::vector<char> known(linear_of.size(), 0);
    for (int e = 0; e < quadratic.num_elements(); ++e) {
      for (std::size_t i = 0; i < kHexEdges.size(); ++i) {
        const int middle = quadratic.elements(8 + static_cast<int>(i), e);
        if (std::exchange(known[static_cast<std::size_t>(middle)], 1) != 0) continue;
        std::array<int, 3> edge = {middle, 0, 0};
        for (std::size_t end = 0; end < 2; ++end) {
          const int corner = quadratic.elements(kHexEdges[i][end], e);
          edge[1 + end] = linear_of[static_cast<std::size_t>(corner)];
        }
        m_edges.push_back(edge);
      }
    }
  }

  /// (3 num_nodes of the hex8, node by node) to (3 num_nodes, component by component).
  [[nodiscard]] Eigen::VectorXf prolong(const Eigen::VectorXd& linear) const {
    Eigen::VectorXf result(3 * m_num_nodes);
    for (int a = 0; a < 3; ++a) {
      float* into = result.data() + a * m_num_nodes;
      for (std::size_t n = 0; n < m_node_of.size(); ++n) {
        into[m_node_of[n]] = static_cast<float>(linear[3 * static_cast<Eigen::Index>(n) + a]);
      }
      for (const auto& [middle, from, to] : m_edges) {
        into[middle] = static_cast<float>(0.5 * (linear[3 * from + a] + linear[3 * to + a]));
      }
    }
    return result;
  }
  /// Its transpose.
  [[nodiscard]] Eigen::VectorXd restrict_to_linear(const Eigen::VectorXf& r) const {
    Eigen::VectorXd result(3 * static_cast<Eigen::Index>(m_node_of.size()));
    for (int a = 0; a < 3; ++a) {
      const float* from_all = r.data() + a * m_num_nodes;
      for (std::size_t n = 0; n < m_node_of.size(); ++n) {
        result[3 * static_cast<Eigen::Index>(n) + a] = from_all[m_node_of[n]];
      }
      for (const auto& [middle, from, to] : m_edges) {
        const double half = 0.5 * static_cast<double>(from_all[middle]);
        result[3 * from + a] += half;
        result[3 * to + a] += half;
      }
    }
    return result;
  }
  [[nodiscard]] double memory_bytes() const { return 12.0 * static_cast<double>(m_edges.size()); }

 private:
  std::vector<int> m_node_of;
  int m_num_nodes;
  std::vector<std::array<int, 3>> m_edges;  ///< middle, and of the hex8 the two ends
};

class QuadraticProblem final : public GridProblem {
 public:
  QuadraticProblem(const ElasticBody& body, const FreeDofs& free, int max_coarse_dofs)
      : QuadraticProblem(body, free, max_coarse_dofs, linear_mesh(body.mesh())) {}

  [[nodiscard]] const std::vector<char>& held() const override { return m_held; }
  [[nodiscard]] Eigen::VectorXd from_free(const Eigen::VectorXd& free) const override {
    return from_full(m_free.expand_vector(free));
  }
  [[nodiscard]] Eigen::VectorXd to_free(const Eigen::VectorXd& own) const override {
    return m_free.restrict_vector(to_full(own));
  }
  [[nodiscard]] Eigen::VectorXd from_full(const Eigen::VectorXd& full) const override {
    Eigen::VectorXd own(full.size());
    own.reshaped(m_num_nodes, 3) = full.reshaped(3, m_num_nodes).transpose();
    zero_held(own);
    return own;
  }
  [[nodiscard]] Eigen::VectorXd to_full(const Eigen::VectorXd& own) const override {
    Eigen::VectorXd full(own.size());
    full.reshaped(3, m_num_nodes) = own.reshaped(m_num_nodes, 3).transpose();
    return full;
  }

  [[nodiscard]] LinearMap matrix(const StiffnessCombination& of,
                                 const Eigen::VectorXd& u) const override;
  [[nodiscard]] SolveStatus prepare(const StiffnessCombination& of) override;
  [[nodiscard]] Eigen::VectorXd cycle(const Eigen::VectorXd& r) override;

  [[nodiscard]] SparseMatrix coarsest_matrix(const StiffnessCombination& of) const override {
    return m_multigrid.coarsest_matrix(of);
  }
  [[nodiscard]] Eigen::VectorXd solve_coarsest(const Eigen::VectorXd& b) override {
    return m_multigrid.solve_coarsest(b);
  }
  [[nodiscard]] Eigen::VectorXd prolong_from_coarsest(const Eigen::VectorXd& x) override {
    Eigen::VectorXd own =
        m_interpolation.prolong(m_linear.to_full(m_multigrid.prolong_from_coarsest(x)))
            .cast<double>();
    zero_held(own);
    return own;
  }
  [[nodiscard]] int coarsest_dofs() const override { return m_multigrid.coarsest_dofs(); }
  [[nodiscard]] int num_levels() const override { return 1 + m_multigrid.num_levels(); }
  [[nodiscard]] double memory_bytes() const override {
    return m_multigrid.memory_bytes() + m_smoother.memory_bytes() + m_interpolation.memory_bytes() +
           80.0 * m_body.mesh().num_elements();
  }

 private:
  QuadraticProblem(const ElasticBody& body,
                   const FreeDofs& free,
                   int max_coarse_dofs,
                   const LinearMesh& linear)
      : m_body(body),
        m_free(free),
        m_num_nodes(body.mesh().num_nodes()),
        m_held(static_cast<std::size_t>(3 * m_num_nodes), 0),
        m_cells(body),
        m_interpolation(body.mesh(), linear.node_of),
        m_linear(ElasticBody(linear.mesh, body.materials(), ConstitutiveModel::Linear),
                 linear_free(linear, free, m_num_nodes)),
        m_multigrid(m_linear, max_coarse_dofs),
        m_smoother(m_num_nodes) {
    for (const int dof : free.held_dofs()) {
      const int own = dof % 3 * m_num_nodes + dof / 3;
      m_held[static_cast<std::size_t>(own)] = 1;
      m_held_dofs.push_back(own);
    }
  }

  template <class Vector>
  void zero_held(Vector& own) const {
    for (const int dof : m_held_dofs) own[dof] = 0;
  }

  const ElasticBody& m_body;
  const FreeDofs& m_free;
  int m_num_nodes;
  std::vector<char> m_held;
  std::vector<int> m_held_dofs;
  QuadraticCells m_cells;
  Interpolation m_interpolation;
  VoxelBody m_linear;
  Multigrid m_multigrid;
  ChebyshevSmoother m_smoother;
  QuadraticCells::Matrices<float> m_matrices;
};

LinearMap QuadraticProblem::matrix(const StiffnessCombination& of, const Eigen::VectorXd& u) const {
  const bool deformed =
      u.size() > 0 && u.cwiseAbs().maxCoeff() > 0.0 && m_body.model() != ConstitutiveModel::Linear;
  const StiffnessCombination by_cells = deformed ? StiffnessCombination{0.0, 0.0, of.mass} : of;
  return [this,
          of,
          matrices = m_cells.matrices<double>(by_cells),
          at = deformed ? u : Eigen::VectorXd()](const Eigen::VectorXd& x) {
    Eigen::VectorXd y = Eigen::VectorXd::Zero(x.size());
    if (at.size() > 0) {
      const Eigen::VectorXd w = to_full(x);
      Eigen::VectorXd full = Eigen::VectorXd::Zero(x.size());
      if (of.stiffness != 0.0) full += of.stiffness * m_body.stiffness_product(at, w);
      if (of.damping != 0.0) full += of.damping * m_body.stiffness_damping_force(at, w);
      y = from_full(full);
    }
    m_cells.add_product(matrices, 1.0, x.data(), y.data());
    if (of.mass != 0.0) {
      for (const ElasticBody::PointMass& point : m_body.point_masses()) {
        for (int a = 0; a < 3; ++a) {
          const auto nodes = Eigen::Map<const Eigen::ArrayXi>(
              point.nodes.data(), static_cast<Eigen::Index>(point.nodes.size()));
          const Eigen::ArrayXi dofs = nodes + a * m_num_nodes;
          const double moved = point.weights.dot(x(dofs));
          y(dofs) += of.mass * point.mass_kg * moved * point.weights;
        }
      }
    }
    zero_held(y);
    return y;
  };
}

SolveStatus QuadraticProblem::prepare(const StiffnessCombination& of) {
  m_matrices = m_cells.matrices<float>(of);
  const auto product = [this](float scale, const float* x, float* y) {
    m_cells.add_product(m_matrices, scale, x, y);
    zero_held(y);
  };
  const Eigen::ArrayXXd diagonal = m_cells.diagonal_blocks(m_cells.matrices<double>(of));
  if (!m_smoother.prepare(diagonal, m_held, product)) return SolveStatus::NotPositiveDefinite;
  return m_multigrid.prepare(of);
}

Eigen::VectorXd QuadraticProblem::cycle(const Eigen::VectorXd& r) {
  // Scaled, lest it leave the range of single precision.
  const double scale = r.lpNorm<Eigen::Infinity>();
  if (!(scale > 0.0)) return Eigen::VectorXd::Zero(r.size());
  const auto product = [this](float by, const float* x, float* y) {
    m_cells.add_product(m_matrices, by, x, y);
    zero_held(y);
  };
  m_smoother.r = (r / scale).cast<float>();
  m_smoother.x.setZero();
  m_smoother.smooth(product, true);
  const Eigen::VectorXd coarse = m_interpolation.restrict_to_linear(m_smoother.r);
  m_smoother.step =
      m_interpolation.prolong(m_linear.to_full(m_multigrid.cycle(m_linear.from_full(coarse))));
  zero_held(m_smoother.step);
  m_smoother.x += m_smoother.step;
  product(-1.0F, m_smoother.step.data(), m_smoother.r.data());
  m_smoother.smooth(product, false);
  return scale * m_smoother.x.cast<double>();
}

}  // namespace

std::string quadratic_grid_fault(const HexMesh& mesh) {
  for (int e = 0; e < mesh.num_elements(); ++e) {
    for (std::size_t i = 0; i < kHexEdges.size(); ++i) {
      const Eigen::Vector3d from = mesh.nodes.col(mesh.elements(kHexEdges[i][0], e));
      const Eigen::Vector3d to = mesh.nodes.col(mesh.elements(kHexEdges[i][1], e));
      const Eigen::Vector3d middle = mesh.nodes.col(mesh.elements(8 + static_cast<int>(i), e));
      if (!((middle - 0.5 * (from + to)).norm() <= kOffMiddle * (to - from).norm())) {
        return "its edges are curved";
      }
    }
  }
  return voxel_fault(linear_mesh(mesh).mesh);
}

std::unique_ptr<GridProblem> make_quadratic_problem(const ElasticBody& body,
                                                    const FreeDofs& free,
                                                    int max_coarse_dofs) {
  return std::make_unique<QuadraticProblem>(body, free, max_coarse_dofs);
}

}  // namespace twang
