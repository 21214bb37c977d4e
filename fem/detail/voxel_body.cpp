// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/detail/voxel_body.hpp"

#include "fem/detail/row_edges.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <map>

namespace twang {
namespace {

/// Nodes that lie further off the grid than this do not belong to it [cells].
constexpr double kOffGrid = 1e-5;
constexpr double kMaxCellsAlong = 1e5;

Eigen::Vector3d first_cell_size(const HexMesh& mesh) {
  return mesh.nodes.col(mesh.elements(6, 0)) - mesh.nodes.col(mesh.elements(0, 0));
}

/// Where the nodes of a mesh stand on the grid of its first element, (3 x num_nodes); no column if
/// it is not one.
Eigen::Matrix3Xi places_on_grid(const HexMesh& mesh) {
  const Eigen::Vector3d size = first_cell_size(mesh);
  if (!(size.minCoeff() > 0.0)) return {};
  const Eigen::Vector3d origin = mesh.nodes.rowwise().minCoeff();
  Eigen::Matrix3Xi places(3, mesh.num_nodes());
  for (int n = 0; n < mesh.num_nodes(); ++n) {
    const Eigen::Array3d at = (mesh.nodes.col(n) - origin).cwiseQuotient(size);
    const Eigen::Array3d whole = at.round();
    if (!((at - whole).abs().maxCoeff() < kOffGrid && whole.maxCoeff() < kMaxCellsAlong)) return {};
    places.col(n) = whole.cast<int>();
  }
  return places;
}

/// Corner of an element in VTK's order for each of the grid's, where the grid has the mesh's axes.
constexpr std::array<int, 8> kVtkCorner = {0, 1, 3, 2, 4, 5, 7, 6};

/// Lower corner of each element, (3 x num_elements); no column if an element is not a cell.
Eigen::Matrix3Xi cells_on_grid(const HexMesh& mesh, const Eigen::Matrix3Xi& places) {
  Eigen::Matrix3Xi cells(3, mesh.num_elements());
  for (int e = 0; e < mesh.num_elements(); ++e) {
    cells.col(e) = places.col(mesh.elements(0, e));
    for (int corner = 0; corner < 8; ++corner) {
      const int node = mesh.elements(kVtkCorner[static_cast<std::size_t>(corner)], e);
      if (places.col(node) != cells.col(e) + corner_offset(corner)) return {};
    }
  }
  return cells;
}

Eigen::Matrix3Xi permuted(const Eigen::Matrix3Xi& places, const std::array<int, 3>& axis) {
  Eigen::Matrix3Xi result(3, places.cols());
  for (int a = 0; a < 3; ++a) result.row(a) = places.row(axis[static_cast<std::size_t>(a)]);
  return result;
}

/// The axis with the fewest rows of cells first, the one with the most layers last.
std::array<int, 3> choose_axes(const Eigen::Matrix3Xi& cells) {
  std::array<int, 3> axis = {0, 1, 2};
  std::array<std::size_t, 3> rows = {};
  for (int a = 0; a < 3; ++a) {
    const CellGrid grid(permuted(cells, {a, (a + 1) % 3, (a + 2) % 3}));
    rows[static_cast<std::size_t>(a)] = grid.rows().size();
  }
  std::sort(axis.begin(), axis.end(), [&](int a, int b) {
    return rows[static_cast<std::size_t>(a)] < rows[static_cast<std::size_t>(b)];
  });
  const Eigen::Vector3i layers = cells.rowwise().maxCoeff();
  if (layers[axis[1]] > layers[axis[2]]) std::swap(axis[1], axis[2]);
  return axis;
}

}  // namespace

std::string voxel_fault(const HexMesh& mesh) {
  if (mesh.kind == ElementKind::Hex20) return "its elements have twenty nodes";
  const Eigen::Matrix3Xi places = places_on_grid(mesh);
  const Eigen::Matrix3Xi cells =
      places.cols() > 0 ? cells_on_grid(mesh, places) : Eigen::Matrix3Xi();
  if (cells.cols() == 0) return "its elements are not equal boxes on a regular grid";
  const CellGrid grid(cells);
  if (grid.num_cells() != mesh.num_elements()) return "elements lie on each other";
  if (grid.num_nodes() != mesh.num_nodes()) return "not every node is shared by its elements";
  return {};
}

VoxelBody::VoxelBody(const ElasticBody& body, const FreeDofs& free) : m_num_free(free.size()) {
  const HexMesh& mesh = body.mesh();
  const Eigen::Matrix3Xi mesh_places = places_on_grid(mesh);
  const Eigen::Matrix3Xi mesh_cells = cells_on_grid(mesh, mesh_places);
  m_axis = choose_axes(mesh_cells);
  m_enhanced = mesh.kind == ElementKind::Hex8e;
  const Eigen::Vector3d size = first_cell_size(mesh);
  for (int a = 0; a < 3; ++a) m_cell_size[a] = size[m_axis[static_cast<std::size_t>(a)]];
  const Eigen::Matrix3Xi cells = permuted(mesh_cells, m_axis);
  m_grid = CellGrid(cells);

  take_materials(body, cells);

  const int num_nodes = m_grid.num_nodes();
  std::vector<int> free_from_full(static_cast<std::size_t>(3 * num_nodes), -1);
  for (int f = 0; f < free.size(); ++f) {
    const int full = free.full_from_free()[static_cast<std::size_t>(f)];
    free_from_full[static_cast<std::size_t>(full)] = f;
  }
  m_full_from_own.resize(3 * num_nodes);
  m_free_from_own.resize(3 * num_nodes);
  m_held.assign(static_cast<std::size_t>(3 * num_nodes), 0);
  std::vector<int> own_node(static_cast<std::size_t>(num_nodes));
  const Eigen::Matrix3Xi places = permuted(mesh_places, m_axis);
  for (int n = 0; n < num_nodes; ++n) {
    const int own = m_grid.find_node(places.col(n));
    own_node[static_cast<std::size_t>(n)] = own;
    for (int a = 0; a < 3; ++a) {
      const int full = 3 * n + m_axis[static_cast<std::size_t>(a)];
      m_full_from_own[a * num_nodes + own] = full;
      m_free_from_own[a * num_nodes + own] = free_from_full[static_cast<std::size_t>(full)];
    }
  }
  std::vector<int> held;
  for (int i = 0; i < 3 * num_nodes; ++i) {
    if (m_free_from_own[i] >= 0) continue;
    m_held[static_cast<std::size_t>(i)] = 1;
    held.push_back(i);
  }
  m_held_dofs = Eigen::Map<Eigen::ArrayXi>(held.data(), static_cast<Eigen::Index>(held.size()));
  for (const ElasticBody::PointMass& point : body.point_masses()) {
    PointMass own{{}, point.weights, point.mass_kg};
    for (const int node : point.nodes) {
      own.nodes.push_back(own_node[static_cast<std::size_t>(node)]);
    }
    m_point_masses.push_back(own);
  }
}

void VoxelBody::take_materials(const ElasticBody& body, const Eigen::Matrix3Xi& cells) {
  const HexMesh& mesh = body.mesh();
  for (const ElasticMaterial& material : body.materials()) {
    const LameConstants lame = lame_constants(material.youngs_modulus_pa, material.poissons_ratio);
    m_materials.push_back(
        {lame.mu, lame.lambda, material.density_kg_m3, material.damping_stiffness_b_s});
  }
  m_material_of_cell.resize(m_grid.num_cells());
  m_type_of_cell.resize(m_grid.num_cells());
  m_stiffness_fill.resize(mesh.stiffness_fill.size());
  m_mass_fill.resize(mesh.mass_fill.size());
  std::map<std::array<int, 3>, int> known;
  const auto steps = [](double fill) {
    return std::max(1, static_cast<int>(std::lround(kFillSteps * fill)));
  };
  for (int e = 0; e < mesh.num_elements(); ++e) {
    const int cell = m_grid.find_cell(cells.col(e));
    const int material = mesh.material_of_element[static_cast<std::size_t>(e)];
    m_material_of_cell[cell] = material;
    double stiffness = 1.0;
    double mass = 1.0;
    if (m_stiffness_fill.size() > 0) {
      m_stiffness_fill[cell] = stiffness = mesh.stiffness_fill[e];
    }
    if (m_mass_fill.size() > 0) m_mass_fill[cell] = mass = mesh.mass_fill[e];
    const std::array<int, 3> key = {material, steps(stiffness), steps(mass)};
    const auto [at, added] = known.try_emplace(key, static_cast<int>(m_types.size()));
    m_type_of_cell[cell] = at->second;
    if (!added) continue;
    CellMaterial type = m_materials[static_cast<std::size_t>(material)];
    type.mu *= key[1] / kFillSteps;
    type.lambda *= key[1] / kFillSteps;
    type.density *= key[2] / kFillSteps;
    m_types.push_back(type);
  }
}

double VoxelBody::incompressibility() const {
  double most = 0.0;
  for (const CellMaterial& material : m_materials) {
    most = std::max(most, material.lambda / material.mu);
  }
  return most;
}

Eigen::VectorXd VoxelBody::from_free(const Eigen::VectorXd& free) const {
  Eigen::VectorXd own(size());
  for (int i = 0; i < size(); ++i) {
    own[i] = m_free_from_own[i] >= 0 ? free[m_free_from_own[i]] : 0.0;
  }
  return own;
}

Eigen::VectorXd VoxelBody::to_free(const Eigen::VectorXd& own) const {
  Eigen::VectorXd free(m_num_free);
  for (int i = 0; i < size(); ++i) {
    if (m_free_from_own[i] >= 0) free[m_free_from_own[i]] = own[i];
  }
  return free;
}

Eigen::VectorXd VoxelBody::from_full(const Eigen::VectorXd& full) const {
  Eigen::VectorXd own = full(m_full_from_own);
  own(m_held_dofs).setZero();
  return own;
}

Eigen::VectorXd VoxelBody::to_full(const Eigen::VectorXd& own) const {
  Eigen::VectorXd full(size());
  full(m_full_from_own) = own;
  return full;
}

template <class Real>
CellModuli<Real> VoxelBody::moduli(const StiffnessCombination& of) const {
  const double volume = m_cell_size.prod() / 64.0;
  CellModuli<Real> result;
  const bool stiff = of.stiffness != 0.0 || of.damping != 0.0;
  if (stiff) {
    result.mu.resize(m_grid.num_cells());
    result.lambda.resize(m_grid.num_cells());
  }
  if (of.mass != 0.0) result.mass.resize(m_grid.num_cells());
  for (int c = 0; c < m_grid.num_cells(); ++c) {
    const CellMaterial& at = m_materials[static_cast<std::size_t>(m_material_of_cell[c])];
    const double stiffness_fill = m_stiffness_fill.size() > 0 ? m_stiffness_fill[c] : 1.0;
    const double mass_fill = m_mass_fill.size() > 0 ? m_mass_fill[c] : 1.0;
    const double factor = volume * stiffness_fill * (of.stiffness + of.damping * at.damping_b);
    if (stiff) {
      result.mu[c] = static_cast<Real>(factor * at.mu);
      result.lambda[c] = static_cast<Real>(factor * at.lambda);
    }
    if (of.mass != 0.0)
      result.mass[c] = static_cast<Real>(volume * mass_fill * of.mass * at.density);
  }
  return result;
}

template <class Real>
CellConstants<Real> VoxelBody::constants(Real scale) const {
  CellConstants<Real> result;
  for (int a = 0; a < 3; ++a) result.per_half[a] = static_cast<Real>(2.0 / m_cell_size[a]);
  result.scale = scale;
  return result;
}

template <class Real>
void VoxelBody::add_product(const CellModuli<Real>& A, Real scale, const Real* x, Real* y) const {
  const CellConstants<Real> common = constants(scale);
  const RowProducts<Real>& products = voxel_kernels().products<Real>(m_enhanced);
  const auto product = A.mu.size() == 0     ? products.mass
                       : A.mass.size() == 0 ? products.stiffness
                                            : products.both;
  if (A.mu.size() == 0 && A.mass.size() == 0) return;
  const std::ptrdiff_t nodes = m_grid.num_nodes();
  m_grid.for_each_row([&](const CellGrid::Row& from) {
    CellRow<Real> row;
    point_at_edges(from, nodes, x, y, row);
    row.mu = A.mu.data() + from.first_cell;
    row.lambda = A.lambda.data() + from.first_cell;
    row.mass = A.mass.data() + from.first_cell;
    product(common, row);
  });
  for (const int dof : m_held_dofs) y[dof] = Real(0.0);
}

void VoxelBody::add_point_masses(double factor,
                                 const Eigen::VectorXd& x,
                                 Eigen::VectorXd& y) const {
  if (factor == 0.0) return;
  for (const PointMass& point : m_point_masses) {
    for (int a = 0; a < 3; ++a) {
      const int first = a * num_nodes();
      double value = 0.0;
      for (std::size_t i = 0; i < point.nodes.size(); ++i) {
        value += point.weights[static_cast<Eigen::Index>(i)] * x[first + point.nodes[i]];
      }
      for (std::size_t i = 0; i < point.nodes.size(); ++i) {
        const int dof = first + point.nodes[i];
        if (m_held[static_cast<std::size_t>(dof)] != 0) continue;
        y[dof] += factor * point.mass_kg * point.weights[static_cast<Eigen::Index>(i)] * value;
      }
    }
  }
}

Eigen::MatrixXd VoxelBody::cell_matrix(const StiffnessCombination& of, int type) const {
  const CellMaterial& at = m_types[static_cast<std::size_t>(type)];
  const double volume = m_cell_size.prod() / 64.0;
  const double factor = volume * (of.stiffness + of.damping * at.damping_b);
  const double mu = factor * at.mu;
  const double lambda = factor * at.lambda;
  const double mass = volume * of.mass * at.density;
  const RowProducts<double>& products = voxel_kernels().products<double>(m_enhanced);
  const bool stiff = of.stiffness != 0.0 || of.damping != 0.0;
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(24, 24);
  for (int column = 0; column < 24; ++column) {
    const Eigen::VectorXd unit = Eigen::VectorXd::Unit(24, column);
    CellRow<double> row;
    const CellGrid::Row one_cell = {0, 1, {0, 2, 4, 6}};
    point_at_edges(one_cell, 8, unit.data(), matrix.col(column).data(), row);
    row.mu = &mu;
    row.lambda = &lambda;
    row.mass = &mass;
    (stiff ? products.both : products.mass)(constants(1.0), row);
  }
  return matrix;
}

template CellModuli<double> VoxelBody::moduli(const StiffnessCombination&) const;
template CellModuli<float> VoxelBody::moduli(const StiffnessCombination&) const;
template void VoxelBody::add_product(const CellModuli<double>&,
                                     double,
                                     const double*,
                                     double*) const;
template void VoxelBody::add_product(const CellModuli<float>&, float, const float*, float*) const;

}  // namespace twang
