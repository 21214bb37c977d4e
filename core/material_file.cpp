// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/material_file.hpp"

#include "core/atomic_file.hpp"
#include "core/detail/object_reader.hpp"
#include "core/error.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <limits>
#include <map>
#include <string>

namespace twang {
namespace {

using detail::Json;
using detail::ObjectReader;

constexpr const char* kMaterialFormat = "twang-material/1";

Provenance provenance_from(const ObjectReader& reader) {
  Provenance provenance;
  provenance.twang_version = reader.text("twang_version");
  provenance.date = reader.text("date");
  provenance.options = reader.texts("options");
  for (const Json& input : reader.array("inputs")) {
    if (!input.is_object() || !input.contains("file") || !input.at("file").is_string() ||
        !input.contains("sha256") || !input.at("sha256").is_string()) {
      reader.fail("inputs", input, "a list of objects with the texts file and sha256");
    }
    provenance.inputs.push_back(
        {input.at("file").get<std::string>(), input.at("sha256").get<std::string>()});
  }
  return provenance;
}

Json json_of(const Refinement& refinement) {
  return {{"linear_youngs_modulus_numerical_pa", refinement.linear_youngs_modulus_numerical_pa},
          {"linear_damping_stiffness_b_s", refinement.linear_damping_stiffness_b_s},
          {"modulus_change_rel", refinement.modulus_change_rel},
          {"modulus_sigma_rel", refinement.modulus_sigma_rel},
          {"damping_change_rel", refinement.damping_change_rel},
          {"damping_sigma_rel", refinement.damping_sigma_rel},
          {"periods", refinement.periods},
          {"amplitude", refinement.amplitude},
          {"residual_rel", refinement.residual_rel},
          {"linear_residual_rel", refinement.linear_residual_rel},
          {"samples", refinement.samples},
          {"simulations", refinement.simulations}};
}

Refinement refinement_from(const ObjectReader& reader) {
  Refinement refinement;
  refinement.linear_youngs_modulus_numerical_pa =
      reader.positive("linear_youngs_modulus_numerical_pa");
  refinement.linear_damping_stiffness_b_s = reader.non_negative("linear_damping_stiffness_b_s");
  refinement.modulus_change_rel = reader.number("modulus_change_rel");
  refinement.modulus_sigma_rel = reader.number("modulus_sigma_rel");
  refinement.damping_change_rel = reader.number("damping_change_rel");
  refinement.damping_sigma_rel = reader.number("damping_sigma_rel");
  refinement.periods = reader.number("periods");
  refinement.amplitude = reader.number("amplitude");
  refinement.residual_rel = reader.number("residual_rel");
  refinement.linear_residual_rel = reader.number("linear_residual_rel");
  refinement.samples = reader.count("samples");
  refinement.simulations = reader.count("simulations");
  return refinement;
}

}  // namespace

std::string material_to_json(const Material& material) {
  const UncertaintyBudget& budget = material.uncertainty;
  Json inputs = Json::array();
  for (const ProvenanceInput& input : material.provenance.inputs) {
    inputs.push_back({{"file", input.file}, {"sha256", input.sha256}});
  }
  // nlohmann writes what is not finite as null and doubles so that they read back exactly.
  Json json = {
      {"format", kMaterialFormat},
      {"material", material.material},
      {"youngs_modulus_identified_pa", material.youngs_modulus_identified_pa},
      {"youngs_modulus_identified_sigma_pa", material.youngs_modulus_identified_sigma_pa},
      {"youngs_modulus_numerical_pa", material.youngs_modulus_numerical_pa},
      {"numerical_element", material.numerical_element},
      {"numerical_dx_mm", material.numerical_dx_mm},
      {"numerical_elements", material.numerical_elements},
      {"rig_sha256", material.rig_sha256},
      {"damping_stiffness_b_s", material.damping_stiffness_b_s},
      {"damping_stiffness_b_sigma_s", material.damping_stiffness_b_sigma_s},
      {"damping_mass_a_per_s", material.damping_mass_a_per_s},
      {"poissons_ratio", material.poissons_ratio},
      {"density_kg_m3", material.density_kg_m3},
      {"frequency_hz", material.frequency_hz},
      {"frequency_sigma_hz", material.frequency_sigma_hz},
      {"decay_per_s", material.decay_per_s},
      {"decay_sigma_per_s", material.decay_sigma_per_s},
      {"lambda_per_s2", material.lambda_per_s2},
      {"tan_delta", material.tan_delta},
      {"amplitude_range", material.amplitude_range},
      {"amplitude_unit", material.amplitude_unit},
      {"eigenmode", material.eigenmode},
      {"eigenmode_reason", material.eigenmode_reason},
      {"uncertainty",
       {{"statistical", budget.statistical},
        {"repeats", budget.repeats},
        {"mesh", budget.mesh},
        {"clock", budget.clock},
        {"dimension", budget.dimension},
        {"density", budget.density},
        {"poissons_ratio", budget.poissons_ratio}}},
      {"validation",
       {{"rms_rel", material.validation.rms_rel},
        {"frequency_error_rel", material.validation.frequency_error_rel},
        {"decay_error_rel", material.validation.decay_error_rel}}},
      {"specimen", material.specimen},
      {"provenance",
       {{"twang_version", material.provenance.twang_version},
        {"inputs", inputs},
        {"options", material.provenance.options},
        {"date", material.provenance.date}}},
  };
  if (material.reported_youngs_modulus_pa) {
    json["reported_youngs_modulus_pa"] = *material.reported_youngs_modulus_pa;
  }
  if (material.refinement) json["refinement"] = json_of(*material.refinement);
  // A file name or an option may hold bytes that are not UTF-8; JSON cannot.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

Material read_material(const std::filesystem::path& path) {
  const std::string file = path.string();
  Json json;
  try {
    json = Json::parse(read_file(path));
  } catch (const Json::parse_error& error) {
    throw InputError(fmt::format(
        "{}: is not valid JSON at byte {}, must be a {} file", file, error.byte, kMaterialFormat));
  }
  if (!json.is_object())
    throw InputError(
        fmt::format("{}: holds no JSON object, must be a {} file", file, kMaterialFormat));
  const ObjectReader reader(json, file, "");
  if (const std::string format = reader.text("format"); format != kMaterialFormat) {
    throw InputError(
        fmt::format("{}: format is \"{}\", must be \"{}\"", file, format, kMaterialFormat));
  }
  Material material;
  material.material = reader.text("material");
  material.youngs_modulus_identified_pa = reader.positive("youngs_modulus_identified_pa");
  material.youngs_modulus_identified_sigma_pa = reader.number("youngs_modulus_identified_sigma_pa");
  material.youngs_modulus_numerical_pa = reader.positive("youngs_modulus_numerical_pa");
  material.numerical_element = reader.text("numerical_element");
  material.numerical_dx_mm = reader.positive("numerical_dx_mm");
  material.numerical_elements = reader.count("numerical_elements");
  material.rig_sha256 = reader.text("rig_sha256");
  material.damping_stiffness_b_s = reader.non_negative("damping_stiffness_b_s");
  material.damping_stiffness_b_sigma_s = reader.number("damping_stiffness_b_sigma_s");
  material.damping_mass_a_per_s = reader.finite("damping_mass_a_per_s");
  material.poissons_ratio = reader.poissons_ratio("poissons_ratio");
  material.density_kg_m3 = reader.positive("density_kg_m3");
  material.frequency_hz = reader.number("frequency_hz");
  material.frequency_sigma_hz = reader.number("frequency_sigma_hz");
  material.decay_per_s = reader.number("decay_per_s");
  material.decay_sigma_per_s = reader.number("decay_sigma_per_s");
  material.lambda_per_s2 = reader.number("lambda_per_s2");
  material.tan_delta = reader.number("tan_delta");
  const Json& range = reader.array("amplitude_range");
  if (range.size() != 2) reader.fail("amplitude_range", range, "two numbers");
  for (std::size_t i = 0; i < 2; ++i) {
    if (!range[i].is_number() && !range[i].is_null()) {
      reader.fail("amplitude_range", range, "two numbers");
    }
    material.amplitude_range[i] = range[i].is_number() ? range[i].get<double>() : kNaN;
  }
  if (reader.has("amplitude_unit")) material.amplitude_unit = reader.text("amplitude_unit");
  if (reader.has("reported_youngs_modulus_pa")) {
    material.reported_youngs_modulus_pa = reader.positive("reported_youngs_modulus_pa");
  }
  if (reader.has("eigenmode")) material.eigenmode = reader.count("eigenmode");
  if (reader.has("eigenmode_reason")) material.eigenmode_reason = reader.text("eigenmode_reason");
  const ObjectReader budget = reader.object("uncertainty");
  material.uncertainty = {budget.number("statistical"),
                          budget.number("repeats"),
                          budget.number("mesh"),
                          budget.number("clock"),
                          budget.number("dimension"),
                          budget.number("density"),
                          budget.number("poissons_ratio")};
  const ObjectReader validation = reader.object("validation");
  material.validation = {validation.number("rms_rel"),
                         validation.number("frequency_error_rel"),
                         validation.number("decay_error_rel")};
  if (reader.has("refinement")) material.refinement = refinement_from(reader.object("refinement"));
  if (reader.has("specimen")) material.specimen = reader.texts("specimen");
  material.provenance = provenance_from(reader.object("provenance"));
  return material;
}

void write_material(const std::filesystem::path& path, const Material& material) {
  write_file_atomically(path, material_to_json(material));
}

}  // namespace twang
