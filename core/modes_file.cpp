// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/modes_file.hpp"

#include "core/atomic_file.hpp"
#include "core/detail/object_reader.hpp"

#include <cmath>

namespace twang {
namespace {

using detail::Json;
using detail::ObjectReader;

constexpr const char* kModesFormat = "twang-modes/1";

}  // namespace

std::vector<DampedSinusoid> read_modes(const std::filesystem::path& path) {
  const std::string file = path.string();
  Json json;
  try {
    json = Json::parse(read_file(path));
  } catch (const Json::parse_error& error) {
    throw InputError(fmt::format("{}: is no JSON ({})", file, error.what()));
  }
  if (!json.is_object()) throw InputError(fmt::format("{}: must be a JSON object", file));
  const ObjectReader reader(json, file, "");
  if (reader.text("format") != kModesFormat) reader.fail("format", json.at("format"), kModesFormat);
  if (reader.has("columns") && !reader.has("modes")) {
    throw InputError(fmt::format(
        "{}: holds several columns, each with modes of its own, must be of one column or --joint",
        file));
  }
  std::vector<DampedSinusoid> modes;
  for (const Json& entry : reader.array("modes")) {
    if (!entry.is_object()) reader.fail("modes", entry, "a list of objects");
    const ObjectReader mode(entry, file, fmt::format("modes[{}].", modes.size()));
    DampedSinusoid& sinusoid = modes.emplace_back();
    sinusoid.frequency_hz = mode.non_negative("frequency_hz");
    sinusoid.decay_per_s = mode.non_negative("decay_per_s");
    if (!(sinusoid.lambda_per_s2() > 0.0) || !std::isfinite(sinusoid.lambda_per_s2())) {
      mode.fail("frequency_hz",
                entry.at("frequency_hz"),
                "> 0 unless decay_per_s is, and both of a size that can be squared");
    }
    if (mode.has("frequency_sigma_hz")) {
      sinusoid.frequency_sigma_hz = mode.non_negative("frequency_sigma_hz");
    }
    if (mode.has("decay_sigma_per_s")) {
      sinusoid.decay_sigma_per_s = mode.non_negative("decay_sigma_per_s");
    }
    if (mode.has("frequency_decay_covariance")) {
      sinusoid.frequency_decay_covariance = mode.finite("frequency_decay_covariance");
    }
  }
  return modes;
}

}  // namespace twang
