// SPDX-License-Identifier: GPL-3.0-or-later
#include "calibrate/render_rig.hpp"

#include "calibrate/simulated_observable.hpp"
#include "calibrate/simulated_release.hpp"
#include "coarsen/fit_material.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "fem/attach_weights.hpp"
#include "fem/static_solve.hpp"
#include "fem/thinnest_wall.hpp"

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace twang {
namespace {

/// When a body is let go, and how it gets back into its held shape in between.
struct PluckTimes {
  std::vector<double> releases_s;
  double hold_s = 0.0;
  double pull_s = 0.0;
};

/// A body moving in a few of its eigenmodes, let go from rest at each release.
class ModalMotion {
 public:
  ModalMotion(const Eigenmodes& modes,
              const Eigen::VectorXd& amplitudes,
              const ElasticMaterial& material,
              PluckTimes times)
      : m_modes(&modes),
        m_amplitudes(amplitudes),
        m_material(material),
        m_times(std::move(times)) {}

  /// Displacement of every node at a time, (3 num_nodes) [m].
  [[nodiscard]] Eigen::VectorXd displacement(double time_s) const {
    return m_modes->shapes * coordinates(time_s);
  }

  /// Modal coordinates: those of the held body before a release, free ones after it, and a smooth
  /// change from these to those during the next pull.
  [[nodiscard]] Eigen::VectorXd coordinates(double time_s) const {
    const auto& releases = m_times.releases_s;
    const auto next = std::upper_bound(releases.begin(), releases.end(), time_s);
    if (next == releases.begin()) return m_amplitudes;
    const Eigen::VectorXd c = free_coordinates(time_s - *(next - 1));
    if (next == releases.end()) return c;
    const double pulled =
        std::clamp((time_s - (*next - m_times.hold_s - m_times.pull_s)) / m_times.pull_s, 0.0, 1.0);
    const double share = 0.5 * (1.0 - std::cos(kPi * pulled));
    return share * m_amplitudes + (1.0 - share) * c;
  }

 private:
  /// A time after a release:
  ///
  ///     c(tau) = c0 exp(-d tau) (cos w tau + d/w sin w tau),   w = 2 pi f     [eq. (13) from rest]
  [[nodiscard]] Eigen::VectorXd free_coordinates(double tau) const {
    Eigen::VectorXd c = m_amplitudes;
    for (Eigen::Index i = 0; i < c.size(); ++i) {
      const double lambda = m_modes->lambda_per_s2[i];
      const double d =
          0.5 * (m_material.damping_mass_a_per_s + m_material.damping_stiffness_b_s * lambda);
      const double w2 = lambda - d * d;
      if (w2 > 0.0) {
        const double w = std::sqrt(w2);
        c[i] *= std::exp(-d * tau) * (std::cos(w * tau) + d / w * std::sin(w * tau));
      } else {
        const double w = std::sqrt(std::max(-w2, 1e-12 * d * d));
        c[i] *= 0.5 * ((1.0 + d / w) * std::exp((w - d) * tau) +
                       (1.0 - d / w) * std::exp(-(w + d) * tau));
      }
    }
    return c;
  }

  const Eigenmodes* m_modes;
  Eigen::VectorXd m_amplitudes;
  ElasticMaterial m_material;
  PluckTimes m_times;
};

/// Where the release holds the body, projected on its modes: c = phi' M u.
Eigen::VectorXd held_amplitudes(const Rig& rig,
                                const ElasticBody& body,
                                const MeshRung& rung,
                                double factor) {
  const Release& release = *rig.release;
  const MeshPoint point = locate(rung.mesh, release.at);
  StaticLoad load;
  if (release.displacement) {
    load.pulled_point = point;
    load.pull = factor * *release.displacement;
  } else {
    load.force = Eigen::VectorXd::Zero(rung.mesh.num_dofs());
    for (std::size_t i = 0; i < point.nodes.size(); ++i) {
      load.force.segment<3>(3 * point.nodes[i]) +=
          factor * point.weights[static_cast<Eigen::Index>(i)] * *release.force;
    }
  }
  const StaticResult held = solve_static(body, rung.held_nodes, load);
  if (!held.usable())
    throw NumericalFailure(fmt::format("the release cannot be reached: {}", held.message));
  return rung.modes.shapes.transpose() * (body.mass() * held.u);
}

/// Sees the moving mesh as the camera does.
class Scene {
 public:
  Scene(const Rig& rig, const HexMesh& mesh) : m_rig(&rig), m_mesh(&mesh) {
    for (const Marker& marker : rig.markers) {
      m_points.push_back(marker.fixed ? MeshPoint{} : locate(mesh, marker.position));
    }
    const Eigen::Vector3d towards_camera = rig.camera->image_down.cross(rig.camera->image_right);
    for (const auto& face : surface_faces(mesh)) {
      const Eigen::Vector3d diagonal1 = mesh.nodes.col(face[2]) - mesh.nodes.col(face[0]);
      const Eigen::Vector3d diagonal2 = mesh.nodes.col(face[3]) - mesh.nodes.col(face[1]);
      constexpr double kSeen = 1e-9;
      if (diagonal1.cross(diagonal2).dot(towards_camera) > kSeen * diagonal1.squaredNorm())
        m_faces.push_back(face);
    }
  }

  /// What is looked at, ascending.
  [[nodiscard]] std::vector<int> nodes() const {
    std::set<int> seen;
    for (const MeshPoint& point : m_points) seen.insert(point.nodes.begin(), point.nodes.end());
    for (const auto& face : m_faces) seen.insert(face.begin(), face.end());
    return {seen.begin(), seen.end()};
  }

  /// @param u  of every node (3 num_nodes) [m]
  [[nodiscard]] FilmedState with(const Eigen::VectorXd& u) const {
    FilmedState state;
    const Eigen::Vector3d right = m_rig->camera->image_right;
    const Eigen::Vector3d up = -m_rig->camera->image_down;
    for (std::size_t i = 0; i < m_rig->markers.size(); ++i) {
      MarkerPose pose;
      pose.position = m_rig->markers[i].position;
      if (!m_rig->markers[i].fixed) {
        pose.position += interpolate(m_points[i], u);
        const Eigen::Matrix3d gradient = interpolate_gradient(m_points[i], u);
        pose.turn_rad = 0.5 * (up.dot(gradient * right) - right.dot(gradient * up));
      }
      state.markers.push_back(pose);
    }
    for (const auto& face : m_faces) {
      std::array<Eigen::Vector3d, 4> corners;
      for (std::size_t k = 0; k < 4; ++k)
        corners[k] = m_mesh->nodes.col(face[k]) + u.segment<3>(3 * face[k]);
      state.part_faces.push_back(corners);
    }
    return state;
  }

 private:
  const Rig* m_rig;
  const HexMesh* m_mesh;
  std::vector<MeshPoint> m_points;
  std::vector<std::array<int, 4>> m_faces;
};

/// Displacement of the nodes that are seen at a time of the film (3 num_nodes) [m].
using Displacement = std::function<Eigen::VectorXd(double time_s)>;

Displacement modal_motion(const Rig& rig,
                          const ElasticBody& body,
                          const MeshRung& rung,
                          const ElasticMaterial& material,
                          const PluckTimes& times,
                          const RenderOptions& options) {
  const Eigen::VectorXd amplitudes = held_amplitudes(rig, body, rung, options.amplitude);
  return [motion = ModalMotion(rung.modes, amplitudes, material, times)](double time_s) {
    return motion.displacement(time_s);
  };
}

Displacement simulated_motion(const Rig& rig,
                              const MeshRung& rung,
                              const ElasticMaterial& material,
                              const std::vector<int>& nodes,
                              const RenderOptions& options) {
  SimulatedReleaseOptions release;
  release.factor = options.amplitude;
  release.duration_s = options.film.duration_s - options.hold_s;
  release.frequency_hz = rung.modes.natural_frequency_hz(0);
  release.progress = options.progress;
  return [motion = simulate_release(rig, rung.mesh, rung.held_nodes, material, nodes, release),
          hold_s = options.hold_s](double time_s) { return motion.displacement(time_s - hold_s); };
}

}  // namespace

void RenderOptions::check() const {
  if (dx_m && !(*dx_m > 0.0)) throw InputError(fmt::format("dx_m is {}, must be > 0", *dx_m));
  if (!std::isfinite(amplitude) || amplitude == 0.0) {
    throw InputError(fmt::format("amplitude is {}, must be a number other than 0", amplitude));
  }
  if (!(hold_s >= 0.0) || hold_s >= film.duration_s) {
    throw InputError(fmt::format("hold_s is {}, must be >= 0 and below the film's duration of {} s",
                                 hold_s,
                                 film.duration_s));
  }
  if (plucks < 1) throw InputError(fmt::format("plucks is {}, must be >= 1", plucks));
  if (plucks > 1 && !(pull_s > 0.0)) {
    throw InputError(fmt::format("pull_s is {}, must be > 0", pull_s));
  }
  if (plucks > 1 && hold_s + pull_s >= film.duration_s / plucks) {
    throw InputError(
        fmt::format("hold_s and pull_s are {} s together, must be below {} s, the film's duration "
                    "over its {} plucks",
                    hold_s + pull_s,
                    film.duration_s / plucks,
                    plucks));
  }
  if (nonlinear && plucks > 1) {
    throw InputError(fmt::format("plucks is {}, must be 1 for a nonlinear simulation", plucks));
  }
  if (num_modes < 1) throw InputError(fmt::format("num_modes is {}, must be >= 1", num_modes));
  film.check();
}

RenderTruth render_rig(const Rig& rig,
                       const ElasticMaterial& material,
                       const std::filesystem::path& video,
                       const RenderOptions& options) {
  options.check();
  if (!rig.release)
    throw InputError(fmt::format("{}: release is missing, must say how the part is deflected",
                                 rig.file.string()));
  report_progress(options.progress, {"eigenmodes", 0.0, 1.0});
  MeshRung rung;
  rung.mesh = mesh_part(rig, options.dx_m.value_or(thinnest_wall_m(rig)), options.element);
  rung.held_nodes = clamped_nodes(rung.mesh, rig);
  ElasticBody body(rung.mesh,
                   std::vector<ElasticMaterial>(rung.mesh.material_names.size(), material),
                   ConstitutiveModel::Linear);
  attach_weights(body, rig.masses);
  EigenmodeOptions eigen;
  eigen.count = options.num_modes;
  rung.modes = compute_eigenmodes(body, rung.held_nodes, eigen);
  if (!rung.modes.usable()) throw NumericalFailure(rung.modes.message);

  PluckTimes times{{}, options.hold_s, options.pull_s};
  for (int i = 0; i < options.plucks; ++i) {
    times.releases_s.push_back(options.hold_s + i * options.film.duration_s / options.plucks);
  }
  const Scene scene(rig, rung.mesh);
  const Displacement displacement =
      options.nonlinear ? simulated_motion(rig, rung, material, scene.nodes(), options)
                        : modal_motion(rig, body, rung, material, times, options);
  FilmOptions film = options.film;
  film.progress = options.progress;

  RenderTruth truth;
  truth.youngs_modulus_pa = material.youngs_modulus_pa;
  truth.damping_stiffness_b_s = material.damping_stiffness_b_s;
  const FrequencyAndDecay first = frequency_and_decay(
      rung.modes.lambda_per_s2[0], material.damping_mass_a_per_s, material.damping_stiffness_b_s);
  truth.frequency_hz = first.frequency_hz;
  truth.decay_per_s = first.decay_per_s;
  truth.hold_s = options.hold_s;
  truth.nonlinear = options.nonlinear;
  truth.releases_s = times.releases_s;
  truth.num_elements = rung.mesh.num_elements();
  truth.dx_m = rung.mesh.requested_dx_m;
  truth.observable_at_release = kNaN;
  if (rig.observable) {
    const double si = SimulatedObservable(rig, rung).evaluate(displacement(0.0));
    truth.observable_at_release =
        rig.observable->kind == ObservableKind::Displacement ? si * kMillimetresPerMetre : si;
  }
  LadderOptions ladder = options.ladder;
  ladder.progress = options.progress;
  Rig unit_rig = rig;  // the limit is asked at E = 1 Pa and this material's other constants
  for (RigMaterial& rig_material : unit_rig.materials) {
    rig_material.youngs_modulus_pa.reset();
    rig_material.poissons_ratio = material.poissons_ratio;
    rig_material.density_kg_m3 = material.density_kg_m3;
  }
  truth.youngs_modulus_limit_pa =
      rung.modes.lambda_per_s2[0] / build_mesh_ladder(unit_rig, ladder).limit.lambda_per_s2;
  truth.film = render_film(
      rig, [&](double time_s) { return scene.with(displacement(time_s)); }, video, film);
  return truth;
}

std::string truth_to_json(const Rig& rig, const RenderTruth& truth) {
  nlohmann::ordered_json json = {
      {"format", "twang-truth/1"},
      {"rig", rig.name},
      {"rig_sha256", rig.sha256},
      {"youngs_modulus_pa", truth.youngs_modulus_pa},
      {"youngs_modulus_limit_pa", truth.youngs_modulus_limit_pa},
      {"damping_stiffness_b_s", truth.damping_stiffness_b_s},
      {"frequency_hz", truth.frequency_hz},
      {"decay_per_s", truth.decay_per_s},
      {"release_s", truth.hold_s},
      {"releases_s", truth.releases_s},
      {"observable_at_release", truth.observable_at_release},
      {"dx_mm", truth.dx_m * kMillimetresPerMetre},
      {"elements", truth.num_elements},
      {"nonlinear", truth.nonlinear},
      {"mm_per_px", truth.film.mm_per_px},
  };
  nlohmann::ordered_json markers;
  for (std::size_t m = 0; m < rig.markers.size(); ++m) {
    nlohmann::ordered_json path = nlohmann::ordered_json::array();
    for (const auto& frame : truth.film.position_px) {
      // a thousandth of a pixel is finer than any tracker and keeps the file small
      path.push_back({std::round(frame[m].x() * 1e3) / 1e3, std::round(frame[m].y() * 1e3) / 1e3});
    }
    markers[rig.markers[m].id] = std::move(path);
  }
  json["position_px"] = std::move(markers);
  json["doubled_frames"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < truth.film.doubled.size(); ++i) {
    if (truth.film.doubled[i]) json["doubled_frames"].push_back(i);
  }
  return json.dump() + "\n";
}

}  // namespace twang
