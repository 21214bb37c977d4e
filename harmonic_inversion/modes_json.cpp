// SPDX-License-Identifier: GPL-3.0-or-later
#include "harmonic_inversion/invert_harmonics.hpp"
#include "harmonic_inversion/releases.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace twang {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kFormat = "twang-modes/1";

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json mode_json(const DampedSinusoid& mode) {
  Json channels = Json::object();
  for (const SinusoidInChannel& channel : mode.channels) {
    channels[channel.channel] = {{"amplitude", finite_or_null(channel.amplitude)},
                                 {"amplitude_sigma", finite_or_null(channel.amplitude_sigma)},
                                 {"phase_rad", finite_or_null(channel.phase_rad)},
                                 {"phase_sigma_rad", finite_or_null(channel.phase_sigma_rad)}};
  }
  return {{"frequency_hz", finite_or_null(mode.frequency_hz)},
          {"frequency_sigma_hz", finite_or_null(mode.frequency_sigma_hz)},
          {"decay_per_s", finite_or_null(mode.decay_per_s)},
          {"decay_sigma_per_s", finite_or_null(mode.decay_sigma_per_s)},
          {"frequency_decay_covariance", finite_or_null(mode.frequency_decay_covariance)},
          {"natural_frequency_hz", finite_or_null(mode.natural_frequency_hz())},
          {"natural_frequency_sigma_hz", finite_or_null(mode.natural_frequency_sigma_hz())},
          {"damping_ratio", finite_or_null(mode.damping_ratio())},
          {"damping_ratio_sigma", finite_or_null(mode.damping_ratio_sigma())},
          {"lambda_per_s2", finite_or_null(mode.lambda_per_s2())},
          {"lambda_sigma_per_s2", finite_or_null(mode.lambda_sigma_per_s2())},
          {"damping_stiffness_b_s", finite_or_null(mode.damping_stiffness_b_s())},
          {"damping_stiffness_b_sigma_s", finite_or_null(mode.damping_stiffness_b_sigma_s())},
          {"error", finite_or_null(mode.error)},
          {"channels", channels}};
}

Json check_json(const DecayCheck& check) {
  return {{"method", check.method},
          {"channel", check.channel},
          {"frequency_hz", finite_or_null(check.frequency_hz)},
          {"frequency_sigma_hz", finite_or_null(check.frequency_sigma_hz)},
          {"decay_per_s", finite_or_null(check.decay_per_s)},
          {"decay_sigma_per_s", finite_or_null(check.decay_sigma_per_s)},
          {"num_points", check.num_points},
          {"message", check.message}};
}

/// `decay_checks`, where there are any.
void add_checks(Json& out, const InversionResult& result) {
  if (result.decay_checks.empty()) return;
  out["decay_checks"] = Json::array();
  for (const DecayCheck& check : result.decay_checks)
    out["decay_checks"].push_back(check_json(check));
}

/// `weights`, one a channel.
Json weights_json(const std::vector<ChannelWeights>& weights) {
  Json out = Json::object();
  for (const ChannelWeights& channel : weights) {
    const bool stated = !channel.sigma_column.empty();
    out[channel.channel] = {{"sigma_column", stated ? Json(channel.sigma_column) : Json(nullptr)},
                            {"sigma_factor", finite_or_null(channel.sigma_factor)},
                            {"extra_sigma", finite_or_null(channel.extra_sigma)},
                            {"left_out", channel.num_left_out},
                            {"down_weighted", channel.num_down_weighted}};
  }
  return out;
}

/// The fields of one inversion, in the order of the format's description.
void add_fields(Json& out, const InversionResult& result) {
  out["time_origin_s"] = finite_or_null(result.time_origin_s);
  out["time_end_s"] = finite_or_null(result.time_end_s);
  out["release_s"] = result.release_s ? finite_or_null(*result.release_s) : Json(nullptr);
  out["modes"] = Json::array();
  for (const DampedSinusoid& mode : result.modes) out["modes"].push_back(mode_json(mode));
  out["offsets"] = Json::object();
  out["drifts_per_s"] = Json::object();
  for (std::size_t c = 0; c < result.channel_names.size(); ++c) {
    out["offsets"][result.channel_names[c]] = finite_or_null(result.offsets[c]);
    out["drifts_per_s"][result.channel_names[c]] = finite_or_null(result.drifts_per_s[c]);
  }
  out["residual_rms"] = finite_or_null(result.residual_rms);
  out["snr_db"] = finite_or_null(result.snr_db);
  out["num_samples"] = result.num_samples;
  out["weights"] = weights_json(result.weights);
  out["method"] = result.method;
  out["rejected"] = Json::array();
  for (const RejectedMode& mode : result.rejected) {
    out["rejected"].push_back({{"frequency_hz", finite_or_null(mode.frequency_hz)},
                               {"decay_per_s", finite_or_null(mode.decay_per_s)},
                               {"reason", mode.reason}});
  }
  out["notes"] = result.notes;
  out["remarks"] = result.remarks;
  out["message"] = result.message;
  out["amplitude_windows"] = Json::array();
  for (const AmplitudeWindow& window : result.amplitude_windows) {
    out["amplitude_windows"].push_back(
        {{"recording", window.recording + 1},
         {"start_s", window.start_s},
         {"end_s", window.end_s},
         {"amplitude", finite_or_null(window.amplitude)},
         {"frequency_hz", finite_or_null(window.frequency_hz)},
         {"frequency_sigma_hz", finite_or_null(window.frequency_sigma_hz)},
         {"decay_per_s", finite_or_null(window.decay_per_s)},
         {"decay_sigma_per_s", finite_or_null(window.decay_sigma_per_s)}});
  }
  add_checks(out, result);
}

/// What one recording says alone of the mode that all share.
Json repeat_json(const RepeatedInversion& repeated, std::size_t n) {
  const InversionResult& alone = repeated.alone[n];
  const DampedSinusoid* mode = repeated.mode_alone(n);
  const auto value = [&](double DampedSinusoid::*field) {
    return mode == nullptr ? Json(nullptr) : finite_or_null(mode->*field);
  };
  Json out = {{"release_s", alone.release_s ? finite_or_null(*alone.release_s) : Json(nullptr)},
              {"time_origin_s", finite_or_null(alone.time_origin_s)},
              {"time_end_s", finite_or_null(alone.time_end_s)},
              {"frequency_hz", value(&DampedSinusoid::frequency_hz)},
              {"frequency_sigma_hz", value(&DampedSinusoid::frequency_sigma_hz)},
              {"decay_per_s", value(&DampedSinusoid::decay_per_s)},
              {"decay_sigma_per_s", value(&DampedSinusoid::decay_sigma_per_s)},
              {"message", alone.message}};
  add_checks(out, alone);
  return out;
}

/// Adds the fields of recordings inverted together, and of each alone.
void add_fields(Json& out, const RepeatedInversion& repeated) {
  add_fields(out, repeated.joint);
  out["repeats"] = Json::array();
  for (std::size_t n = 0; n < repeated.alone.size(); ++n) {
    out["repeats"].push_back(repeat_json(repeated, n));
  }
  out["repeat_scatter"] = {{"frequency_hz", finite_or_null(repeated.frequency_scatter_hz)},
                           {"decay_per_s", finite_or_null(repeated.decay_scatter_per_s)}};
}

template <class Result>
std::string text_of(const Result& result) {
  Json out;
  out["format"] = kFormat;
  add_fields(out, result);
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

template <class Result>
std::string text_of(const std::vector<std::pair<std::string, Result>>& columns) {
  Json out;
  out["format"] = kFormat;
  out["columns"] = Json::object();
  for (const auto& [name, result] : columns) {
    Json fields = Json::object();
    add_fields(fields, result);
    out["columns"][name] = std::move(fields);
  }
  return out.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

std::string modes_to_json(const InversionResult& result) { return text_of(result); }
std::string modes_to_json(const RepeatedInversion& repeated) { return text_of(repeated); }
std::string modes_to_json(const std::vector<std::pair<std::string, InversionResult>>& columns) {
  return text_of(columns);
}
std::string modes_to_json(const std::vector<std::pair<std::string, RepeatedInversion>>& columns) {
  return text_of(columns);
}

}  // namespace twang
