// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/multigrid_preconditioner.hpp"

#include "core/error.hpp"
#include "fem/detail/multigrid.hpp"
#include "fem/detail/thread_limits.hpp"
#include "fem/detail/voxel_body.hpp"

#include <fmt/format.h>

#include <map>
#include <string>

namespace twang {
namespace {

const ElasticBody& checked(const ElasticBody& body) {
  const std::string fault = voxel_fault(body.mesh());
  if (!fault.empty()) throw InputError(fmt::format("multigrid does not fit the mesh: {}", fault));
  return body;
}

}  // namespace

struct MultigridPreconditioner::Impl {
  Impl(const ElasticBody& body, const FreeDofs& free, int max_coarse_dofs)
      : voxels(checked(body), free), cycles(voxels, max_coarse_dofs) {}
  VoxelBody voxels;
  Multigrid cycles;
};

MultigridPreconditioner::MultigridPreconditioner(const ElasticBody& body,
                                                 const FreeDofs& free,
                                                 int max_coarse_dofs)
    : m_impl(std::make_unique<Impl>(body, free, max_coarse_dofs)) {}
MultigridPreconditioner::~MultigridPreconditioner() = default;

SolveStatus MultigridPreconditioner::prepare(const StiffnessCombination& of) {
  return m_impl->cycles.prepare(of);
}

Eigen::VectorXd MultigridPreconditioner::apply(const Eigen::VectorXd& r) const {
  const PoliteThreads threads;
  return m_impl->voxels.to_free(m_impl->cycles.cycle(m_impl->voxels.from_free(r)));
}

Eigen::VectorXd MultigridPreconditioner::diagonal(const StiffnessCombination& of) const {
  const VoxelBody& voxels = m_impl->voxels;
  const auto nodes = voxels.grid().nodes_of_cells();
  std::map<int, Eigen::VectorXd> of_type;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(voxels.size());
  for (int cell = 0; cell < voxels.grid().num_cells(); ++cell) {
    const int type = voxels.type_of_cell(cell);
    auto found = of_type.find(type);
    if (found == of_type.end())
      found = of_type.emplace(type, voxels.cell_matrix(of, type).diagonal()).first;
    for (int component = 0; component < 3; ++component)
      for (int corner = 0; corner < 8; ++corner)
        sum[component * voxels.num_nodes() + nodes(corner, cell)] +=
            found->second[8 * component + corner];
  }
  return voxels.to_free(sum);
}

bool prefers_multigrid(const ElasticBody& body,
                       const FreeDofs& free,
                       const StiffnessSolverOptions& options) {
  options.check();
  switch (options.kind) {
    case StiffnessSolverKind::Factor:
      return false;
    case StiffnessSolverKind::Multigrid:
      return true;
    case StiffnessSolverKind::Automatic:
      break;
  }
  return estimate_factor_bytes(free.size()) > options.max_factor_bytes &&
         voxel_fault(body.mesh()).empty();
}

}  // namespace twang
