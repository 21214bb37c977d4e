// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/video_reader.hpp"

#include "capture/detail/ffmpeg.hpp"
#include "capture/detail/luma_plane.hpp"
#include "capture/detail/packet_scan.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace twang {
namespace {

using namespace detail;

// Pictures a decoder may leave out at the start of an open group of pictures.
constexpr long kForgivenPictures = 8;
// Largest relative difference between the average and the nominal rate of one and the same film.
constexpr double kSameRate = 1e-3;
// No camera films larger ones; a damaged header may ask for any [px].
constexpr std::int64_t kMaxPixels = 1LL << 27;

void check_luma(const std::filesystem::path& path, int format) {
  if (has_luma(format)) return;
  const char* name = av_get_pix_fmt_name(static_cast<AVPixelFormat>(format));
  throw InputError(fmt::format("{}: pixel format is {}, must have luma of 8 to 16 bits (yuv420p)",
                               path.string(),
                               name ? name : "unknown"));
}

/// Whether a format is a bare sequence of pictures, which knows no time; FFmpeg would invent 25
/// frames a second.
bool is_timeless(const AVInputFormat& format) {
  return (format.flags & AVFMT_NOTIMESTAMPS) || std::string_view(format.name).ends_with("_pipe");
}

/// The container's rate: the nominal one where it says the same as the average.
std::optional<double> declared_rate(const AVFormatContext& container,
                                    const AVStream& stream,
                                    const AVCodecContext& codec) {
  const auto rate = [](AVRational q) { return q.num > 0 && q.den > 0 ? av_q2d(q) : 0.0; };
  if (is_timeless(*container.iformat)) {
    const double coded = rate(codec.framerate);
    return coded > 0.0 ? std::optional(coded) : std::nullopt;
  }
  const double average = rate(stream.avg_frame_rate);
  const double nominal = rate(stream.r_frame_rate);
  if (average <= 0.0) return nominal > 0.0 ? std::optional(nominal) : std::nullopt;
  return std::abs(nominal - average) <= kSameRate * average ? nominal : average;
}

/// The rate at which a camera says it filmed, from keys such as Android's `com.android.capture.fps`
/// and those under `com.apple.quicktime` that end alike.
std::optional<double> capture_rate_tag(const AVDictionary* tags) {
  constexpr std::array<std::string_view, 3> kEndings = {
      "capture.fps", "capture-fps", "capture-frame-rate"};
  const AVDictionaryEntry* tag = nullptr;
  while ((tag = av_dict_get(tags, "", tag, AV_DICT_IGNORE_SUFFIX)) != nullptr) {
    std::string key = tag->key;
    std::transform(key.begin(), key.end(), key.begin(), [](unsigned char c) {
      return static_cast<char>(std::tolower(c));
    });
    const bool known = std::any_of(kEndings.begin(), kEndings.end(), [&](std::string_view ending) {
      return key.ends_with(ending);
    });
    const double value = known ? std::strtod(tag->value, nullptr) : 0.0;
    if (std::isfinite(value) && value > 0.0) return value;
  }
  return std::nullopt;
}

bool is_interlaced(AVFieldOrder order) {
  return order != AV_FIELD_UNKNOWN && order != AV_FIELD_PROGRESSIVE;
}

/// Width of a shown pixel over its height; 1 where the file says nothing, or nonsense.
double pixel_aspect(const OpenedFilm& film, bool sides_swapped) {
  constexpr double kMostSlender = 4.0;  // of any format in use
  const AVRational ratio = av_guess_sample_aspect_ratio(film.container.get(), film.stream, nullptr);
  if (ratio.num <= 0 || ratio.den <= 0) return 1.0;
  const double stored = av_q2d(ratio);
  if (stored > kMostSlender || stored < 1.0 / kMostSlender) return 1.0;
  return sides_swapped ? 1.0 / stored : stored;
}

CodecContextPtr open_decoder(const std::filesystem::path& path, const AVStream& stream) {
  const AVCodecParameters& parameters = *stream.codecpar;
  const AVCodec* decoder = avcodec_find_decoder(parameters.codec_id);
  if (!decoder) {
    throw InputError(fmt::format("{}: codec {} is not known, must be one that FFmpeg decodes",
                                 path.string(),
                                 avcodec_get_name(parameters.codec_id)));
  }
  CodecContextPtr codec(avcodec_alloc_context3(decoder));
  avcodec_parameters_to_context(codec.get(), &parameters);
  codec->pkt_timebase = stream.time_base;
  codec->max_pixels = kMaxPixels;
  codec->thread_count = 0;  // one a core
  codec->thread_type = FF_THREAD_FRAME | FF_THREAD_SLICE;
  if (const int opened = avcodec_open2(codec.get(), decoder, nullptr); opened < 0) {
    throw InputError(fmt::format(
        "{}: cannot be decoded as {} ({})", path.string(), decoder->name, error_text(opened)));
  }
  return codec;
}

}  // namespace

struct VideoReader::Impl {
  std::filesystem::path path;
  PacketScan scan;
  OpenedFilm film;
  CodecContextPtr codec;
  FramePtr frame{av_frame_alloc()};
  PacketPtr packet{av_packet_alloc()};
  VideoInfo info;
  LumaPlane luma;
  bool restore_order = false;  // stamps come from the scan, in ascending order
  bool sent_last = false;
  long decoded = 0;  // pictures out of the decoder
  long shown = 0;    // of these, handed to the caller

  [[noreturn]] void fail(const std::string& why) const {
    throw InputError(fmt::format("{}: breaks off after frame {}: {}", path.string(), shown, why));
  }

  /// Gives the decoder the next packet of the picture stream, or the end.
  void feed() {
    while (true) {
      const int status = av_read_frame(film.container.get(), packet.get());
      if (status == AVERROR_EOF) {
        sent_last = true;
        avcodec_send_packet(codec.get(), nullptr);
        return;
      }
      if (status < 0) fail(error_text(status));
      if (packet->stream_index == film.stream->index) break;
      av_packet_unref(packet.get());
    }
    if (restore_order) packet->flags &= ~AV_PKT_FLAG_DISCARD;
    const int sent = avcodec_send_packet(codec.get(), packet.get());
    av_packet_unref(packet.get());
    if (sent < 0) fail(fmt::format("the next picture cannot be decoded ({})", error_text(sent)));
  }

  /// Decodes the next picture into `frame`; false at the end.
  bool decode() {
    while (true) {
      const int status = avcodec_receive_frame(codec.get(), frame.get());
      if (status == AVERROR_EOF) return false;
      if (status == AVERROR(EAGAIN)) {
        if (sent_last) return false;
        feed();
        continue;
      }
      if (status < 0) {
        fail(fmt::format("the next picture cannot be decoded ({})", error_text(status)));
      }
      if ((frame->flags & AV_FRAME_FLAG_CORRUPT) || frame->decode_error_flags != 0) {
        fail("the next picture is damaged");
      }
      ++decoded;
      return true;
    }
  }

  [[nodiscard]] double stamp_s() const {
    std::int64_t ticks = frame->best_effort_timestamp;
    if (restore_order) ticks = scan.stamps[static_cast<std::size_t>(decoded - 1)].ticks;
    if (ticks == AV_NOPTS_VALUE || is_timeless(*film.container->iformat)) return kNaN;
    return static_cast<double>(ticks) * info.tick_s;
  }

  /// Whether the picture just decoded was cut away by the edit list.
  [[nodiscard]] bool cut_away() const {
    return restore_order && scan.stamps[static_cast<std::size_t>(decoded - 1)].discarded;
  }
};

VideoReader::VideoReader(const std::filesystem::path& path) : m_impl(std::make_unique<Impl>()) {
  Impl& self = *m_impl;
  self.path = path;
  self.film = open_film(path);
  self.codec = open_decoder(path, *self.film.stream);
  const AVStream& stream = *self.film.stream;
  self.scan = scan_packets(path);
  if (!self.scan.broken.empty()) {
    throw InputError(fmt::format("{}: is cut off: {}", path.string(), self.scan.broken));
  }
  check_luma(path, stream.codecpar->format);
  self.restore_order = self.scan.reordering_lost && stream.codecpar->video_delay > 0;

  VideoInfo& info = self.info;
  const Orientation orientation = orientation_of(stream);
  self.luma = LumaPlane(orientation);
  info.stored_width_px = stream.codecpar->width;
  info.stored_height_px = stream.codecpar->height;
  const bool swap = orientation.swaps_sides();
  info.width_px = swap ? info.stored_height_px : info.stored_width_px;
  info.height_px = swap ? info.stored_width_px : info.stored_height_px;
  info.turned_right = {orientation.right[0], orientation.right[1]};
  info.turned_down = {orientation.down[0], orientation.down[1]};
  info.rotation_deg = orientation.turn_deg();
  info.interlaced = is_interlaced(stream.codecpar->field_order);
  info.pixel_aspect = pixel_aspect(self.film, swap);
  info.tick_s = av_q2d(stream.time_base);
  info.declared_fps = declared_rate(*self.film.container, stream, *self.codec);
  info.capture_fps_tag = capture_rate_tag(self.film.container->metadata);
  if (!info.capture_fps_tag) info.capture_fps_tag = capture_rate_tag(stream.metadata);
  info.declared_frames = self.scan.num_shown();
  info.codec = avcodec_get_name(stream.codecpar->codec_id);
}

VideoReader::~VideoReader() = default;

const VideoInfo& VideoReader::info() const { return m_impl->info; }

std::optional<LumaFrame> VideoReader::read() {
  Impl& self = *m_impl;
  do {
    if (!self.decode()) {
      const long missing = static_cast<long>(self.scan.stamps.size()) - self.decoded;
      const long discarded = static_cast<long>(self.scan.stamps.size()) - self.scan.num_shown();
      const long withheld = self.restore_order ? 0 : discarded;
      if (missing - withheld > kForgivenPictures) {
        self.fail(fmt::format("{} of {} pictures were decoded", self.shown, self.scan.num_shown()));
      }
      return std::nullopt;
    }
    if (self.decoded > static_cast<long>(self.scan.stamps.size()) && self.restore_order) {
      self.restore_order = false;  // more pictures than packets: nothing to sort by
    }
  } while (self.cut_away());
  const AVFrame& frame = *self.frame;
  check_luma(self.path, frame.format);
  if (frame.width != self.info.stored_width_px || frame.height != self.info.stored_height_px) {
    self.fail(fmt::format("the picture is {} x {} px, must stay {} x {} px",
                          frame.width,
                          frame.height,
                          self.info.stored_width_px,
                          self.info.stored_height_px));
  }
  ++self.shown;
  self.info.interlaced = self.info.interlaced || frame.interlaced_frame != 0;
  LumaFrame shown = self.luma.view(frame);
  shown.stamp_s = self.stamp_s();
  shown.coded_bytes = std::max(0, frame.pkt_size);
  shown.coded_as = av_get_picture_type_char(frame.pict_type);
  return shown;
}

}  // namespace twang
