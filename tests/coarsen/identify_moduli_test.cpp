// SPDX-License-Identifier: GPL-3.0-or-later
#include "coarsen/identify_moduli.hpp"

#include "coarsen/mesh_ladder.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "tests/coarsen/rigs_of_tests.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace twang::test {
namespace {

constexpr double kSoft_pa = 1.1e6;
constexpr double kStiff_pa = 2.3e9;
constexpr double kSoftB_s = 3e-3;
constexpr double kStiffB_s = 1.2e-4;
constexpr double kDx_m = 5e-3;

/// A beam along x: a soft root of the given length [mm] that carries a stiff rest, 60 mm in all.
Rig jointed_beam(double soft_mm) {
  const auto mm = [](double x, double y, double z) -> Eigen::Vector3d {
    return Eigen::Vector3d(x, y, z) * 1e-3;
  };
  Rig rig = rig_of_boxes({}, {mm(0, 0, 0), mm(0, 10, 5)}, 0.3, 1100.0);
  rig.name = "jointed";
  rig.materials[0].name = "soft";
  RigMaterial stiff = rig.materials[0];
  stiff.name = "stiff";
  stiff.density_kg_m3 = 1250.0;
  rig.materials.push_back(stiff);
  rig.parts = {{"stiff", Box{mm(0, 0, 0), mm(60, 10, 5)}}};
  if (soft_mm > 0.0) rig.parts.push_back({"soft", Box{mm(0, 0, 0), mm(soft_mm, 10, 5)}});
  return rig;
}

Rig stated(Rig rig) {
  for (RigMaterial& material : rig.materials) {
    material.youngs_modulus_pa = material.name == "soft" ? kSoft_pa : kStiff_pa;
  }
  return rig;
}

/// The damped sinusoid of a mode on the mesh the search starts on, without its dampings.
DampedSinusoid sinusoid_of(const Rig& rig, int mode, double dx_m = kDx_m) {
  const MeshRung rung = compute_rung(stated(rig), dx_m, ElementKind::Hex20, mode + 1);
  DampedSinusoid sinusoid;
  sinusoid.frequency_hz = rung.modes.natural_frequency_hz(mode);
  sinusoid.frequency_sigma_hz = 1e-3 * sinusoid.frequency_hz;
  sinusoid.decay_sigma_per_s = 1e-3;
  return sinusoid;
}

/// Gives a sinusoid the decay of modal damping d = lambda (share_soft b_soft + share_stiff b_stiff)
/// / 2, its natural frequency kept.
void damp(DampedSinusoid& sinusoid, double share_soft) {
  const double omega = kTwoPi * sinusoid.frequency_hz;
  const double d = 0.5 * omega * omega * (share_soft * kSoftB_s + (1.0 - share_soft) * kStiffB_s);
  sinusoid.decay_per_s = d;
  sinusoid.frequency_hz = std::sqrt(omega * omega - d * d) / kTwoPi;
}

/// One mesh alone, that of the synthesized sinusoids: what is found must be the truth to round-off.
IdentifyOptions on_one_mesh() {
  IdentifyOptions options;
  options.dx_m = kDx_m;
  options.max_dofs = 2000;
  return options;
}

TEST(IdentifyModuli, FindsTwoMaterialsFromTwoRigs) {
  const Rig hinged = jointed_beam(10.0);
  const Rig plain = jointed_beam(0.0);
  const auto found = identify_moduli(
      {{&hinged, sinusoid_of(hinged, 0), {}}, {&plain, sinusoid_of(plain, 0), {}}}, on_one_mesh());
  ASSERT_EQ(found.materials.size(), 2U);
  EXPECT_EQ(found.materials[0].name, "soft");
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kSoft_pa, 1.0, 1e-6);
  EXPECT_NEAR(found.materials[1].youngs_modulus_pa / kStiff_pa, 1.0, 1e-6);
  EXPECT_TRUE(found.distinguishable);
  EXPECT_LT(found.condition_number, 3.0);
  // The plain beam is of one material: its share is all.
  EXPECT_NEAR(found.energy_shares(1, 1), 1.0, 1e-9);
  EXPECT_LT(found.misfit.cwiseAbs().maxCoeff(), 1e-6);
  // ln E follows ln lambda, of which a thousandth of f makes two.
  EXPECT_NEAR(found.materials[1].statistical_rel, 2e-3, 1e-5);
}

TEST(IdentifyModuli, FindsTwoMaterialsFromTwoModesAndTheirDampings) {
  // The soft piece is long enough that the second mode bends the stiff rest as well; a stiffness
  // nearer to the soft one's lets it.
  Rig rig = jointed_beam(30.0);
  const auto truth = [&](double soft_pa, double stiff_pa) {
    Rig known = rig;
    known.materials[0].youngs_modulus_pa = soft_pa;
    known.materials[1].youngs_modulus_pa = stiff_pa;
    return known;
  };
  constexpr double kFirm_pa = 8e6;
  const Rig known = truth(kSoft_pa, kFirm_pa);
  const MeshRung rung = compute_rung(known, kDx_m, ElementKind::Hex20, 6);
  std::vector<ModalMeasurement> measurements;
  std::vector<double> shares;
  for (const int mode : {0, 1, 3}) {
    DampedSinusoid sinusoid;
    sinusoid.frequency_hz = rung.modes.natural_frequency_hz(mode);
    sinusoid.frequency_sigma_hz = 1e-3 * sinusoid.frequency_hz;
    sinusoid.decay_sigma_per_s = 1e-3;
    // The share by a difference quotient of the frequency: what it is defined by.
    const MeshRung softer =
        compute_rung(truth(kSoft_pa * 0.999, kFirm_pa), kDx_m, ElementKind::Hex20, 6);
    const MeshRung firmer =
        compute_rung(truth(kSoft_pa * 1.001, kFirm_pa), kDx_m, ElementKind::Hex20, 6);
    shares.push_back(std::log(firmer.modes.lambda_per_s2[mode] / softer.modes.lambda_per_s2[mode]) /
                     std::log(1.001 / 0.999));
    damp(sinusoid, shares.back());
    measurements.push_back({&rig, sinusoid, mode});
  }
  const auto found = identify_moduli(measurements, on_one_mesh());
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kSoft_pa, 1.0, 1e-6);
  EXPECT_NEAR(found.materials[1].youngs_modulus_pa / kFirm_pa, 1.0, 1e-6);
  for (std::size_t k = 0; k < shares.size(); ++k) {
    EXPECT_NEAR(found.energy_shares(static_cast<Eigen::Index>(k), 0), shares[k], 1e-4) << k;
  }
  // Shares by difference quotients err by some 1e-5.
  EXPECT_NEAR(found.materials[0].damping_stiffness_b_s / kSoftB_s, 1.0, 1e-3);
  EXPECT_NEAR(found.materials[1].damping_stiffness_b_s / kStiffB_s, 1.0, 0.02);
}

TEST(IdentifyModuli, AssignsSinusoidsToTheModesThatTheObservableSees) {
  Rig rig = jointed_beam(10.0);
  // Bending in z (the thin way) and in y come in turn; the observable sees y alone.
  Marker tip;
  tip.id = "tip";
  tip.position = {60e-3, 5e-3, 2.5e-3};
  rig.markers = {tip};
  rig.observable =
      ObservableDefinition{ObservableKind::Displacement, {"tip"}, Eigen::Vector3d::UnitY()};
  const Rig plain = jointed_beam(0.0);
  const auto found = identify_moduli(
      {{&rig, sinusoid_of(rig, 1), {}}, {&plain, sinusoid_of(plain, 0), {}}}, on_one_mesh());
  EXPECT_EQ(found.modes[0], 1);
  EXPECT_EQ(found.modes[1], 0);
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kSoft_pa, 1.0, 1e-6);
}

TEST(IdentifyModuli, StandsOnAMaterialOfStatedModulus) {
  Rig rig = jointed_beam(10.0);
  rig.materials[1].youngs_modulus_pa = kStiff_pa;
  const auto found = identify_moduli({{&rig, sinusoid_of(rig, 0), {}}}, on_one_mesh());
  ASSERT_EQ(found.materials.size(), 1U);
  EXPECT_EQ(found.materials[0].name, "soft");
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kSoft_pa, 1.0, 1e-6);
  EXPECT_NEAR(found.known_shares[0] + found.energy_shares(0, 0), 1.0, 1e-12);
}

TEST(IdentifyModuli, SaysWhenTheDataCannotTellMaterialsApart) {
  // Both rigs bend in their soft root alone.
  const Rig a = jointed_beam(10.0);
  const Rig b = jointed_beam(15.0);
  const auto found =
      identify_moduli({{&a, sinusoid_of(a, 0), {}}, {&b, sinusoid_of(b, 0), {}}}, on_one_mesh());
  EXPECT_FALSE(found.distinguishable);
  ASSERT_FALSE(found.notes.empty());
  EXPECT_NE(found.notes.back().find("\"stiff\" holds at most"), std::string::npos)
      << found.notes.back();
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kSoft_pa, 1.0, 0.01);
  EXPECT_LT(found.materials[0].statistical_rel, 0.01);
  EXPECT_TRUE(std::isinf(found.materials[1].statistical_rel));
}

TEST(IdentifyModuli, SaysWhenModesAreMixturesOfOneRatio) {
  const Rig rig = jointed_beam(30.0);
  const DampedSinusoid sinusoid = sinusoid_of(rig, 0);
  const auto found = identify_moduli({{&rig, sinusoid, 0}, {&rig, sinusoid, 0}}, on_one_mesh());
  EXPECT_FALSE(found.distinguishable);
  EXPECT_TRUE(std::isinf(found.materials[0].statistical_rel));
  EXPECT_TRUE(std::isinf(found.materials[1].statistical_rel));
  ASSERT_FALSE(found.notes.empty());
  EXPECT_NE(found.notes.back().find("do not tell"), std::string::npos);
}

TEST(IdentifyModuli, SaysWhichModeTheModuliDoNotExplain) {
  const Rig hinged = jointed_beam(10.0);
  const Rig plain = jointed_beam(0.0);
  DampedSinusoid off = sinusoid_of(plain, 1);
  off.frequency_hz *= 1.2;
  const auto found = identify_moduli({{&hinged, sinusoid_of(hinged, 0), {}},
                                      {&plain, sinusoid_of(plain, 0), 0, "flat.json"},
                                      {&plain, off, 1, "edge.json"}},
                                     on_one_mesh());
  int told = 0;
  for (const std::string& note : found.notes) {
    told += note.find("flat.json") == 0 || note.find("edge.json") == 0 ? 1 : 0;
  }
  EXPECT_EQ(told, 2);  // the one modulus lies between
}

TEST(IdentifyModuli, RefinesTheMeshUntilTheModuliStand) {
  const Rig rig = jointed_beam(0.0);
  // A beam of 60 x 10 x 5 mm on a mesh four times as fine.
  const DampedSinusoid fine = sinusoid_of(rig, 0, 1.25e-3);
  IdentifyOptions options;
  options.convergent_change = 0.005;
  const auto found = identify_moduli({{&rig, fine, {}}}, options);
  EXPECT_LE(found.dx_m[0], 2.5e-3);
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kStiff_pa,
              1.0,
              3.0 * found.materials[0].mesh_rel + 1e-3);
  EXPECT_LT(found.materials[0].mesh_rel, 0.002);
  EXPECT_GT(found.materials[0].mesh_rel, 0.0);
}

TEST(IdentifyModuli, CellsLargerThanThePartAreNoConvergedMesh) {
  const Rig rig = jointed_beam(0.0);
  IdentifyOptions options;
  options.dx_m = 1e3;
  const auto found = identify_moduli({{&rig, sinusoid_of(rig, 0, 1.25e-3), {}}}, options);
  EXPECT_LT(found.dx_m[0], 10e-3);
  EXPECT_NEAR(found.materials[0].youngs_modulus_pa / kStiff_pa, 1.0, 0.02);
}

TEST(IdentifyModuli, RefusesFewerModesThanMaterials) {
  const Rig rig = jointed_beam(10.0);
  DampedSinusoid sinusoid;
  sinusoid.frequency_hz = 10.0;
  try {
    (void)identify_moduli({{&rig, sinusoid, {}}});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "2 materials have no stated modulus and 1 mode is measured, must be as many modes or "
              "more");
  }
  EXPECT_THROW((void)identify_moduli({}), InputError);
  const Rig known = stated(rig);
  EXPECT_THROW((void)identify_moduli({{&known, sinusoid, {}}}), InputError);
}

}  // namespace
}  // namespace twang::test
