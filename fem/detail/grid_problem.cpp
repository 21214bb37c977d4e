// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/grid_problem.hpp"

#include "fem/detail/multigrid.hpp"
#include "fem/detail/quadratic_problem.hpp"
#include "fem/detail/voxel_body.hpp"
#include "fem/detail/voxel_operator.hpp"

namespace twang {
namespace {

/// Of hex8 and hex8e.
class VoxelProblem final : public GridProblem {
 public:
  VoxelProblem(const ElasticBody& body, const FreeDofs& free, int max_coarse_dofs)
      : m_body(body), m_voxels(body, free), m_multigrid(m_voxels, max_coarse_dofs) {}

  [[nodiscard]] const std::vector<char>& held() const override { return m_voxels.held(); }
  [[nodiscard]] Eigen::VectorXd from_free(const Eigen::VectorXd& free) const override {
    return m_voxels.from_free(free);
  }
  [[nodiscard]] Eigen::VectorXd to_free(const Eigen::VectorXd& own) const override {
    return m_voxels.to_free(own);
  }
  [[nodiscard]] Eigen::VectorXd from_full(const Eigen::VectorXd& full) const override {
    return m_voxels.from_full(full);
  }
  [[nodiscard]] Eigen::VectorXd to_full(const Eigen::VectorXd& own) const override {
    return m_voxels.to_full(own);
  }
  [[nodiscard]] LinearMap matrix(const StiffnessCombination& of,
                                 const Eigen::VectorXd& u) const override {
    return VoxelOperator(m_body, m_voxels, of, u);
  }
  [[nodiscard]] SolveStatus prepare(const StiffnessCombination& of) override {
    return m_multigrid.prepare(of);
  }
  [[nodiscard]] Eigen::VectorXd cycle(const Eigen::VectorXd& r) override {
    return m_multigrid.cycle(r);
  }
  [[nodiscard]] SparseMatrix coarsest_matrix(const StiffnessCombination& of) const override {
    return m_multigrid.coarsest_matrix(of);
  }
  [[nodiscard]] Eigen::VectorXd solve_coarsest(const Eigen::VectorXd& b) override {
    return m_multigrid.solve_coarsest(b);
  }
  [[nodiscard]] Eigen::VectorXd prolong_from_coarsest(const Eigen::VectorXd& x) override {
    return m_multigrid.prolong_from_coarsest(x);
  }
  [[nodiscard]] int coarsest_dofs() const override { return m_multigrid.coarsest_dofs(); }
  [[nodiscard]] int num_levels() const override { return m_multigrid.num_levels(); }
  [[nodiscard]] double memory_bytes() const override {
    // Moduli in double precision, maps to and from the mesh.
    return m_multigrid.memory_bytes() + 24.0 * m_voxels.grid().num_cells() + 9.0 * m_voxels.size();
  }

 private:
  const ElasticBody& m_body;
  VoxelBody m_voxels;
  Multigrid m_multigrid;
};

}  // namespace

std::string grid_fault(const HexMesh& mesh) {
  return mesh.kind == ElementKind::Hex20 ? quadratic_grid_fault(mesh) : voxel_fault(mesh);
}

std::unique_ptr<GridProblem> make_grid_problem(const ElasticBody& body,
                                               const FreeDofs& free,
                                               int max_coarse_dofs) {
  if (body.mesh().kind == ElementKind::Hex20) {
    return make_quadratic_problem(body, free, max_coarse_dofs);
  }
  return std::make_unique<VoxelProblem>(body, free, max_coarse_dofs);
}

}  // namespace twang
