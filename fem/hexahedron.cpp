// SPDX-License-Identifier: GPL-3.0-or-later
#include "fem/hexahedron.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace twang {
namespace {

/// Reference coordinates of the 20 nodes; the first 8 are the corners.
constexpr std::array<std::array<int, 3>, 20> kNodes = {{
    {-1, -1, -1}, {1, -1, -1}, {1, 1, -1},  {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1},
    {-1, 1, 1},   {0, -1, -1}, {1, 0, -1},  {0, 1, -1},  {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},
    {0, 1, 1},    {-1, 0, 1},  {-1, -1, 0}, {1, -1, 0},  {1, 1, 0},   {-1, 1, 0},
}};

/// Value and derivative of a factor of a shape function along one axis.
struct Factor {
  double value = 0.0;
  double slope = 0.0;
};

/// (1 + x node) / 2 towards a corner, 1 - x² at a mid-edge node (node 0).
Factor factor(int node, double x) {
  if (node == 0) return {1.0 - x * x, -2.0 * x};
  return {0.5 * (1.0 + node * x), 0.5 * node};
}

struct ShapeValue {
  double value = 0.0;
  Eigen::Vector3d gradient;
};

/// Product of three factors; the corners of hex20 carry a further sum of node . xi - 2.
ShapeValue shape(ElementKind kind, int node, const Eigen::Vector3d& xi) {
  const auto& at = kNodes[static_cast<std::size_t>(node)];
  const Factor fx = factor(at[0], xi.x());
  const Factor fy = factor(at[1], xi.y());
  const Factor fz = factor(at[2], xi.z());
  ShapeValue result{
      fx.value * fy.value * fz.value,
      {fx.slope * fy.value * fz.value,
       fx.value * fy.slope * fz.value,
       fx.value * fy.value * fz.slope},
  };
  if (kind == ElementKind::Hex20 && node < 8) {
    const Eigen::Vector3d corner(at[0], at[1], at[2]);
    const double bubble = corner.dot(xi) - 2.0;
    result.gradient = result.gradient * bubble + result.value * corner;
    result.value *= bubble;
  }
  return result;
}

Quadrature gauss_product(const std::vector<double>& abscissae, const std::vector<double>& weights) {
  Quadrature rule;
  for (std::size_t k = 0; k < abscissae.size(); ++k) {
    for (std::size_t j = 0; j < abscissae.size(); ++j) {
      for (std::size_t i = 0; i < abscissae.size(); ++i) {
        rule.points.emplace_back(abscissae[i], abscissae[j], abscissae[k]);
        rule.weights.push_back(weights[i] * weights[j] * weights[k]);
      }
    }
  }
  return rule;
}

}  // namespace

std::string_view to_string(ElementKind kind) {
  if (kind == ElementKind::Hex8) return "hex8";
  return kind == ElementKind::Hex20 ? "hex20" : "hex8e";
}

ElementKind element_kind_from(std::string_view name) {
  if (name == "hex8") return ElementKind::Hex8;
  if (name == "hex20") return ElementKind::Hex20;
  if (name == "hex8e") return ElementKind::Hex8e;
  throw InputError(
      fmt::format("element is \"{}\", must be \"hex8\", \"hex20\" or \"hex8e\"", name));
}

int nodes_per_element(ElementKind kind) { return kind == ElementKind::Hex20 ? 20 : 8; }

int num_internal_modes(ElementKind kind) { return kind == ElementKind::Hex8e ? 3 : 0; }

Eigen::Vector3d reference_node(int node) {
  const auto& at = kNodes[static_cast<std::size_t>(node)];
  return {static_cast<double>(at[0]), static_cast<double>(at[1]), static_cast<double>(at[2])};
}

Eigen::VectorXd shape_functions(ElementKind kind, const Eigen::Vector3d& xi) {
  Eigen::VectorXd N(nodes_per_element(kind));
  for (int a = 0; a < N.size(); ++a) N[a] = shape(kind, a, xi).value;
  return N;
}

Eigen::Matrix3Xd shape_gradients(ElementKind kind, const Eigen::Vector3d& xi) {
  Eigen::Matrix3Xd dN(3, nodes_per_element(kind));
  for (int a = 0; a < dN.cols(); ++a) dN.col(a) = shape(kind, a, xi).gradient;
  return dN;
}

const Quadrature& quadrature(ElementKind kind) {
  static const Quadrature two =
      gauss_product({-1.0 / std::sqrt(3.0), 1.0 / std::sqrt(3.0)}, {1, 1});
  static const Quadrature three =
      gauss_product({-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0});
  return kind == ElementKind::Hex20 ? three : two;
}

}  // namespace twang
