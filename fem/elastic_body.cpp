// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/elastic_body.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "fem/detail/check_body.hpp"
#include "fem/detail/element_blocks.hpp"
#include "fem/detail/element_geometry.hpp"
#include "fem/detail/element_kernels.hpp"
#include "fem/detail/node_graph.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <mutex>
#include <utility>

namespace twang {
namespace {

constexpr std::size_t kMaxNodes = 20;

double filled(const Eigen::VectorXd& fill, Eigen::Index element) {
  return fill.size() > 0 ? fill[element] : 1.0;
}

/// Lamé constants of every element, the last batch filled up with zeros.
struct ElementModuli {
  std::vector<double> mu;
  std::vector<double> lambda;
};

}  // namespace

struct ElasticBody::Impl {
  HexMesh mesh;
  std::vector<ElasticMaterial> materials;
  ConstitutiveModel model;
  ElementKernels kernels;
  ElementGeometry geometry;
  ElementBlocks blocks;
  ElementModuli moduli;          ///< of the stiffness
  ElementModuli damping_moduli;  ///< the same times b
  std::vector<PointMass> point_masses;

  /// What matrices alone need: far more memory than the rest, made when first asked for.
  struct Assembly {
    NodeGraph graph;
    std::vector<double> node_mass;  ///< for each of the graph's neighbours
    SparseMatrix mass;
  };
  mutable std::once_flag assembling;
  mutable std::unique_ptr<Assembly> assembly;
  [[nodiscard]] Assembly& assembled() const;

  Impl(HexMesh mesh_of_body,
       std::vector<ElasticMaterial> materials_of_body,
       ConstitutiveModel model_of_body);

  [[nodiscard]] ElementModuli scaled_moduli(bool by_damping) const;
  [[nodiscard]] std::vector<double> element_masses(const NodeGraph& graph) const;
  /// integral of rho N over the volume and N of the point masses, for each node [kg]
  [[nodiscard]] Eigen::VectorXd masses_of_nodes() const;
  [[nodiscard]] double density_of(int element) const;
  static void add_to(Assembly& assembly, const PointMass& point);

  /// `u`, or zeros where it is empty.
  [[nodiscard]] Eigen::VectorXd whole(const Eigen::VectorXd& u, const char* name) const;
  void gather(const Eigen::VectorXd& field, int batch, double* lanes) const;
  [[nodiscard]] ElementBatch batch_of(int batch, const ElementModuli& with) const;
  [[nodiscard]] Eigen::VectorXd sum_forces(ElementKernels::Kernel kernel,
                                           const ElementModuli& with,
                                           const Eigen::VectorXd& u,
                                           const Eigen::VectorXd* w) const;
  void sum_tangents(const ElementModuli& with, const Eigen::VectorXd& u, double* values) const;
  void scatter_tangent(int element, int lane, const double* tangent, double* values) const;
};

ElasticBody::Impl::Impl(HexMesh mesh_of_body,
                        std::vector<ElasticMaterial> materials_of_body,
                        ConstitutiveModel model_of_body)
    : mesh(std::move(mesh_of_body)),
      materials(std::move(materials_of_body)),
      model(model_of_body),
      kernels(select_kernels(mesh.kind, model)),
      geometry(mesh),
      blocks(mesh) {
  check_materials(mesh, materials);
  check_fill(mesh);
  moduli = scaled_moduli(false);
  damping_moduli = scaled_moduli(true);
}

ElasticBody::Impl::Assembly& ElasticBody::Impl::assembled() const {
  std::call_once(assembling, [this] {
    auto made = std::make_unique<Assembly>(Assembly{NodeGraph(mesh), {}, {}});
    made->node_mass = element_masses(made->graph);
    for (const PointMass& point : point_masses) add_to(*made, point);
    made->mass = made->graph.diagonal_blocks(made->node_mass);
    assembly = std::move(made);
  });
  return *assembly;
}

void ElasticBody::Impl::add_to(Assembly& assembly, const PointMass& point) {
  for (std::size_t b = 0; b < point.nodes.size(); ++b) {
    for (std::size_t a = 0; a < point.nodes.size(); ++a) {
      const int at = assembly.graph.start(point.nodes[b]) +
                     assembly.graph.find(point.nodes[a], point.nodes[b]);
      assembly.node_mass[static_cast<std::size_t>(at)] +=
          point.mass_kg * point.weights[static_cast<Eigen::Index>(a)] *
          point.weights[static_cast<Eigen::Index>(b)];
    }
  }
}

ElementModuli ElasticBody::Impl::scaled_moduli(bool by_damping) const {
  ElementModuli result;
  const auto padded = static_cast<std::size_t>(geometry.num_batches() * kLanes);
  result.mu.assign(padded, 0.0);
  result.lambda.assign(padded, 0.0);
  for (std::size_t e = 0; e < mesh.material_of_element.size(); ++e) {
    const ElasticMaterial& material =
        materials[static_cast<std::size_t>(mesh.material_of_element[e])];
    const LameConstants lame = lame_constants(material.youngs_modulus_pa, material.poissons_ratio);
    const double scale = (by_damping ? material.damping_stiffness_b_s : 1.0) *
                         filled(mesh.stiffness_fill, static_cast<Eigen::Index>(e));
    result.mu[e] = scale * lame.mu;
    result.lambda[e] = scale * lame.lambda;
  }
  return result;
}

double ElasticBody::Impl::density_of(int element) const {
  const int material = mesh.material_of_element[static_cast<std::size_t>(element)];
  return materials[static_cast<std::size_t>(material)].density_kg_m3 *
         filled(mesh.mass_fill, element);
}

std::vector<double> ElasticBody::Impl::element_masses(const NodeGraph& graph) const {
  std::vector<double> node_mass(graph.neighbours().size(), 0.0);
  Eigen::MatrixXd products = geometry.shape_products(0);
  for (int e = 0; e < mesh.num_elements(); ++e) {
    if (!geometry.congruent()) products = geometry.shape_products(e);
    const double density = density_of(e);
    for (int b = 0; b < products.cols(); ++b) {
      const int start = graph.start(mesh.elements(b, e));
      for (int a = 0; a < products.rows(); ++a) {
        node_mass[static_cast<std::size_t>(start + graph.rank(e, a, b))] +=
            density * products(a, b);
      }
    }
  }
  return node_mass;
}

Eigen::VectorXd ElasticBody::Impl::masses_of_nodes() const {
  // The shape functions sum to one: these are the sums of the rows of their products.
  Eigen::VectorXd masses = Eigen::VectorXd::Zero(mesh.num_nodes());
  Eigen::VectorXd integrals;
  for (int e = 0; e < mesh.num_elements(); ++e) {
    if (e == 0 || !geometry.congruent()) integrals = geometry.shape_products(e).rowwise().sum();
    masses(mesh.elements.col(e)) += density_of(e) * integrals;
  }
  for (const PointMass& point : point_masses) masses(point.nodes) += point.mass_kg * point.weights;
  return masses;
}

Eigen::VectorXd ElasticBody::Impl::whole(const Eigen::VectorXd& u, const char* name) const {
  if (u.size() == 0) return Eigen::VectorXd::Zero(mesh.num_dofs());
  if (u.size() == mesh.num_dofs()) return u;
  throw InputError(fmt::format(
      "{} has {} entries, must have {} (3 for each node)", name, u.size(), mesh.num_dofs()));
}

void ElasticBody::Impl::gather(const Eigen::VectorXd& field, int batch, double* lanes) const {
  const auto nodes = mesh.elements.rows();
  for (int lane = 0; lane < kLanes; ++lane) {
    const int element = std::min(batch * kLanes + lane, mesh.num_elements() - 1);
    for (Eigen::Index a = 0; a < nodes; ++a) {
      const double* from = field.data() + 3 * mesh.elements(a, element);
      for (int i = 0; i < 3; ++i) lanes[(3 * a + i) * kLanes + lane] = from[i];
    }
  }
}

ElementBatch ElasticBody::Impl::batch_of(int batch, const ElementModuli& with) const {
  ElementBatch result;
  result.geometry = geometry.batch(batch);
  result.mu = with.mu.data() + batch * kLanes;
  result.lambda = with.lambda.data() + batch * kLanes;
  return result;
}

Eigen::VectorXd ElasticBody::Impl::sum_forces(ElementKernels::Kernel kernel,
                                              const ElementModuli& with,
                                              const Eigen::VectorXd& u,
                                              const Eigen::VectorXd* w) const {
  using Lanes = std::array<double, 3 * kMaxNodes * kLanes>;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(mesh.num_dofs());
  blocks.for_each_batch([&](int index) {
    Lanes u_lanes, w_lanes, force;
    ElementBatch batch = batch_of(index, with);
    gather(u, index, u_lanes.data());
    batch.u = u_lanes.data();
    if (w != nullptr) gather(*w, index, w_lanes.data());
    batch.w = w_lanes.data();
    kernel(batch, force.data());
    const int last = std::min((index + 1) * kLanes, mesh.num_elements());
    for (int element = index * kLanes; element < last; ++element) {
      const int lane = element - index * kLanes;
      for (Eigen::Index a = 0; a < mesh.elements.rows(); ++a) {
        double* to = sum.data() + 3 * mesh.elements(a, element);
        for (int i = 0; i < 3; ++i) {
          to[i] += force[static_cast<std::size_t>((3 * a + i) * kLanes + lane)];
        }
      }
    }
  });
  return sum;
}

void ElasticBody::Impl::scatter_tangent(int element,
                                        int lane,
                                        const double* tangent,
                                        double* values) const {
  const NodeGraph& graph = assembly->graph;
  const int nodes = static_cast<int>(mesh.elements.rows());
  const double* block = tangent + lane;
  for (int a = 0; a < nodes; ++a) {
    const int node_a = mesh.elements(a, element);
    for (int b = 0; b <= a; ++b, block += 9 * kLanes) {
      const int node_b = mesh.elements(b, element);
      double* to = values + graph.column_start(node_b, 0) + 3 * graph.rank(element, a, b);
      const int stride = 3 * graph.degree(node_b);
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) to[k * stride + i] += block[(3 * k + i) * kLanes];
      }
      if (a == b) continue;
      double* mirrored = values + graph.column_start(node_a, 0) + 3 * graph.rank(element, b, a);
      const int mirrored_stride = 3 * graph.degree(node_a);
      for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k)
          mirrored[i * mirrored_stride + k] += block[(3 * k + i) * kLanes];
      }
    }
  }
}

void ElasticBody::Impl::sum_tangents(const ElementModuli& with,
                                     const Eigen::VectorXd& u,
                                     double* values) const {
  constexpr std::size_t kMaxPairs = kMaxNodes * (kMaxNodes + 1) / 2;
  std::fill(values, values + 9 * assembled().graph.neighbours().size(), 0.0);
  blocks.for_each_batch([&](int index) {
    std::array<double, 3 * kMaxNodes * kLanes> u_lanes;
    std::array<double, kMaxPairs * 9 * kLanes> tangent;
    ElementBatch batch = batch_of(index, with);
    gather(u, index, u_lanes.data());
    batch.u = u_lanes.data();
    kernels.tangent(batch, tangent.data());
    const int last = std::min((index + 1) * kLanes, mesh.num_elements());
    for (int element = index * kLanes; element < last; ++element) {
      scatter_tangent(element, element - index * kLanes, tangent.data(), values);
    }
  });
}

ElasticBody::ElasticBody(HexMesh mesh,
                         std::vector<ElasticMaterial> materials,
                         ConstitutiveModel model)
    : m_impl(std::make_unique<Impl>(std::move(mesh), std::move(materials), model)) {}
ElasticBody::~ElasticBody() = default;
ElasticBody::ElasticBody(ElasticBody&&) noexcept = default;
ElasticBody& ElasticBody::operator=(ElasticBody&&) noexcept = default;

const HexMesh& ElasticBody::mesh() const { return m_impl->mesh; }
const std::vector<ElasticMaterial>& ElasticBody::materials() const { return m_impl->materials; }
ConstitutiveModel ElasticBody::model() const { return m_impl->model; }
const SparseMatrix& ElasticBody::mass() const { return m_impl->assembled().mass; }

void ElasticBody::add_point_mass(const MeshPoint& point, double mass_kg) {
  if (!(mass_kg > 0.0) || !std::isfinite(mass_kg)) {
    throw InputError(fmt::format("a point mass is {} kg, must be > 0", mass_kg));
  }
  const bool known = point.element >= 0 && point.element < m_impl->mesh.num_elements() &&
                     std::equal(point.nodes.begin(),
                                point.nodes.end(),
                                m_impl->mesh.elements.col(point.element).begin(),
                                m_impl->mesh.elements.col(point.element).end());
  if (!known) throw InputError("a point mass lies at a point of another mesh");
  m_impl->point_masses.push_back({point.nodes, point.weights, mass_kg});
  if (m_impl->assembly == nullptr) return;
  Impl::add_to(*m_impl->assembly, m_impl->point_masses.back());
  m_impl->assembly->mass = m_impl->assembly->graph.diagonal_blocks(m_impl->assembly->node_mass);
}

const std::vector<ElasticBody::PointMass>& ElasticBody::point_masses() const {
  return m_impl->point_masses;
}

double ElasticBody::elastic_energy(const Eigen::VectorXd& u) const {
  const Eigen::VectorXd whole_u = m_impl->whole(u, "u");
  const int num_elements = m_impl->mesh.num_elements();
  std::vector<double> energies(static_cast<std::size_t>(m_impl->geometry.num_batches() * kLanes));
  m_impl->blocks.for_each_batch([&](int index) {
    std::array<double, 3 * kMaxNodes * kLanes> lanes;
    ElementBatch batch = m_impl->batch_of(index, m_impl->moduli);
    m_impl->gather(whole_u, index, lanes.data());
    batch.u = lanes.data();
    m_impl->kernels.energy(batch, energies.data() + index * kLanes);
  });
  double sum = 0.0;
  for (int e = 0; e < num_elements; ++e) sum += energies[static_cast<std::size_t>(e)];
  return sum;
}

Eigen::VectorXd ElasticBody::internal_force(const Eigen::VectorXd& u) const {
  return m_impl->sum_forces(m_impl->kernels.force, m_impl->moduli, m_impl->whole(u, "u"), nullptr);
}

SparseMatrix ElasticBody::stiffness(const Eigen::VectorXd& u) const {
  SparseMatrix K = m_impl->assembled().graph.stiffness_pattern();
  m_impl->sum_tangents(m_impl->moduli, m_impl->whole(u, "u"), K.valuePtr());
  return K;
}

SparseMatrix ElasticBody::stiffness_damping(const Eigen::VectorXd& u) const {
  SparseMatrix D = m_impl->assembled().graph.stiffness_pattern();
  m_impl->sum_tangents(m_impl->damping_moduli, m_impl->whole(u, "u"), D.valuePtr());
  return D;
}

Eigen::VectorXd ElasticBody::stiffness_product(const Eigen::VectorXd& u,
                                               const Eigen::VectorXd& w) const {
  const Eigen::VectorXd whole_w = m_impl->whole(w, "w");
  return m_impl->sum_forces(
      m_impl->kernels.product, m_impl->moduli, m_impl->whole(u, "u"), &whole_w);
}

Eigen::VectorXd ElasticBody::stiffness_damping_force(const Eigen::VectorXd& u,
                                                     const Eigen::VectorXd& v) const {
  const Eigen::VectorXd whole_v = m_impl->whole(v, "v");
  return m_impl->sum_forces(
      m_impl->kernels.product, m_impl->damping_moduli, m_impl->whole(u, "u"), &whole_v);
}

void ElasticBody::add_scaled_mass(double factor, SparseMatrix& A) const {
  const Impl::Assembly& assembly = m_impl->assembled();
  const NodeGraph& graph = assembly.graph;
  if (A.rows() != m_impl->mesh.num_dofs() || !A.isCompressed() ||
      A.nonZeros() != 9 * static_cast<Eigen::Index>(graph.neighbours().size())) {
    throw InputError("the mass is added to a matrix that is not a stiffness of the same body");
  }
  for (int b = 0; b < graph.num_nodes(); ++b) {
    for (int column = 0; column < 3; ++column) {
      double* to = A.valuePtr() + graph.column_start(b, column) + column;
      for (int i = 0; i < graph.degree(b); ++i) {
        to[3 * i] += factor * assembly.node_mass[static_cast<std::size_t>(graph.start(b) + i)];
      }
    }
  }
}

Eigen::VectorXd ElasticBody::gravity_force(const Eigen::Vector3d& gravity_m_s2) const {
  return (gravity_m_s2 * m_impl->masses_of_nodes().transpose()).reshaped();
}

}  // namespace twang
