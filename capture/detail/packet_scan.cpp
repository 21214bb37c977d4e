// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/detail/packet_scan.hpp"

#include "core/error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <system_error>

namespace twang::detail {
namespace {

namespace fs = std::filesystem;

// Containers of films; playlists, subtitles and "text as a picture" are none.
constexpr const char* kFilmFormats =
    "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,mpeg,mpegvideo,ogg,flv,asf,mxf,nut,ivf,"
    "yuv4mpegpipe,h264,hevc,m4v,mjpeg,dv,gif,apng,png_pipe,jpeg_pipe,wtv,obu,rm";
// A healthy file may promise the last picture's duration, or a picture or two, too much.
constexpr double kForgivenFrames = 2.5;

void check_regular_file(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (!fs::exists(status)) throw InputError(fmt::format("{}: no such file", path.string()));
  if (fs::is_directory(status)) {
    throw InputError(fmt::format("{}: is a folder, must be a film", path.string()));
  }
  if (!fs::is_regular_file(status)) {
    throw InputError(fmt::format("{}: is no regular file, must be a film", path.string()));
  }
  if (fs::file_size(path, error) == 0 && !error) {
    throw InputError(fmt::format("{}: is empty, must be a film", path.string()));
  }
}

/// "01:02:03.500000000", as Matroska files state a stream's duration; 0 if it is no such text.
double seconds_from_clock(const char* text) {
  int hours = 0;
  int minutes = 0;
  double seconds = 0.0;
  if (std::sscanf(text, "%d:%d:%lf", &hours, &minutes, &seconds) != 3) return 0.0;
  return 3600.0 * hours + 60.0 * minutes + seconds;
}

/// When something ends, as promised by the header and as found.
struct Ends {
  double promised_s = 0.0;  ///< 0: not said
  double found_s = 0.0;
};

/// Where the packets of each stream begin and end [s].
struct StreamSpan {
  bool any = false;
  double first_s = 0.0;
  double end_s = 0.0;

  void add(const AVPacket& packet, AVRational time_base) {
    const std::int64_t stamp = packet.pts != AV_NOPTS_VALUE ? packet.pts : packet.dts;
    if (stamp == AV_NOPTS_VALUE) return;
    const double tick = av_q2d(time_base);
    const double begin = tick * static_cast<double>(stamp);
    const double end =
        begin + tick * static_cast<double>(std::max<std::int64_t>(0, packet.duration));
    first_s = any ? std::min(first_s, begin) : begin;
    end_s = any ? std::max(end_s, end) : end;
    any = true;
  }
  /// The later of the end and the length: some headers state the one, some the other.
  [[nodiscard]] double reach() const { return any ? std::max(end_s, end_s - first_s) : 0.0; }
};

/// Index entries that point behind the end of the file.
std::string beyond_the_end(const AVFormatContext& container, AVStream& stream) {
  const std::int64_t size = container.pb ? avio_size(container.pb) : -1;
  if (size <= 0) return {};
  const int count = avformat_index_get_entries_count(&stream);
  int whole = 0;
  for (int i = 0; i < count; ++i) {
    const AVIndexEntry* entry = avformat_index_get_entry(&stream, i);
    if (entry->size <= 0 || entry->pos + entry->size <= size) ++whole;
  }
  if (whole == count) return {};
  if (stream.nb_frames <= 0) return fmt::format("the file ends after {} frames", whole);
  return fmt::format("the file ends after {} of {} frames", whole, stream.nb_frames);
}

/// A transport stream, which states no length, that ends within one of its packets.
std::string cut_within_a_packet(const AVFormatContext& container) {
  if (std::string_view(container.iformat->name) != "mpegts") return {};
  const std::int64_t size = container.pb ? avio_size(container.pb) : -1;
  constexpr std::array kPacketSizes = {188, 192, 204};  // plain, with time codes, with check bytes
  const bool whole = std::any_of(
      kPacketSizes.begin(), kPacketSizes.end(), [&](int packet) { return size % packet == 0; });
  return size <= 0 || whole ? "" : "the file ends within a transport packet";
}

Ends compare_ends(const OpenedFilm& film, const std::vector<StreamSpan>& spans) {
  const AVFormatContext& container = *film.container;
  const auto index = static_cast<std::size_t>(film.stream->index);
  if (const auto* tag = av_dict_get(film.stream->metadata, "DURATION", nullptr, 0)) {
    return {seconds_from_clock(tag->value), spans[index].reach()};
  }
  if (container.duration_estimation_method == AVFMT_DURATION_FROM_STREAM &&
      film.stream->duration > 0) {
    return {av_q2d(film.stream->time_base) * static_cast<double>(film.stream->duration),
            spans[index].reach()};
  }
  if (container.duration_estimation_method == AVFMT_DURATION_FROM_BITRATE) return {};
  if (container.duration <= 0) return {};
  double found = 0.0;
  for (const StreamSpan& span : spans) found = std::max(found, span.reach());
  return {static_cast<double>(container.duration) / AV_TIME_BASE, found};
}

/// Whether the film stops short of the duration its header states.
std::string stops_short(const OpenedFilm& film,
                        const std::vector<StreamSpan>& spans,
                        const std::vector<PacketScan::Stamp>& stamps) {
  // An MP4's durations speak of what the edit list leaves; its index says more.
  if (avformat_index_get_entries_count(film.stream) >= static_cast<int>(stamps.size()) &&
      std::string(film.container->iformat->name).find("mp4") != std::string::npos) {
    return {};
  }
  double step = av_q2d(av_inv_q(film.stream->avg_frame_rate));
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i - 1].ticks == AV_NOPTS_VALUE) continue;
    step = std::max(step,
                    av_q2d(film.stream->time_base) *
                        static_cast<double>(stamps[i].ticks - stamps[i - 1].ticks));
  }
  const Ends ends = compare_ends(film, spans);
  if (!(step > 0.0) || ends.found_s + kForgivenFrames * step >= ends.promised_s) return {};
  return fmt::format("the file ends after {} frames, {:.3f} s of the {:.3f} s that it states",
                     stamps.size(),
                     ends.found_s,
                     ends.promised_s);
}

}  // namespace

long PacketScan::num_shown() const {
  return static_cast<long>(std::count_if(
      stamps.begin(), stamps.end(), [](const Stamp& stamp) { return !stamp.discarded; }));
}

OpenedFilm open_film(const fs::path& path) {
  silence_ffmpeg();
  check_regular_file(path);
  AVDictionary* options = nullptr;
  av_dict_set(&options, "format_whitelist", kFilmFormats, 0);
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  AVFormatContext* raw = nullptr;
  const int opened =
      avformat_open_input(&raw, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  OpenedFilm film{InputPtr(raw), nullptr};
  if (opened < 0) {
    throw InputError(fmt::format("{}: cannot be opened as a film ({}): it is none, or is cut off",
                                 path.string(),
                                 error_text(opened)));
  }
  if (const int found = avformat_find_stream_info(raw, nullptr); found < 0) {
    throw InputError(
        fmt::format("{}: is no film that can be read ({})", path.string(), error_text(found)));
  }
  const int index = av_find_best_stream(raw, AVMEDIA_TYPE_VIDEO, -1, -1, nullptr, 0);
  if (index < 0) {
    throw InputError(
        fmt::format("{}: has no pictures: it is no film, or is cut off", path.string()));
  }
  film.stream = raw->streams[index];
  if (film.stream->disposition & AV_DISPOSITION_ATTACHED_PIC) {
    throw InputError(fmt::format("{}: has no pictures but a cover, must be a film", path.string()));
  }
  return film;
}

PacketScan scan_packets(const fs::path& path) {
  const OpenedFilm film = open_film(path);
  PacketScan scan;
  scan.reordering_lost = true;
  std::vector<StreamSpan> spans(film.container->nb_streams);
  const PacketPtr packet(av_packet_alloc());
  int status = 0;
  while ((status = av_read_frame(film.container.get(), packet.get())) >= 0) {
    const auto index = static_cast<std::size_t>(packet->stream_index);
    if (index >= spans.size()) spans.resize(index + 1);
    spans[index].add(*packet, film.container->streams[index]->time_base);
    if (packet->stream_index == film.stream->index) {
      if ((packet->flags & AV_PKT_FLAG_CORRUPT) && scan.broken.empty()) {
        scan.broken = fmt::format("the file breaks off within frame {}", scan.stamps.size() + 1);
      }
      scan.stamps.push_back({packet->pts, (packet->flags & AV_PKT_FLAG_DISCARD) != 0});
      scan.reordering_lost &= packet->pts != AV_NOPTS_VALUE && packet->pts == packet->dts;
    }
    av_packet_unref(packet.get());
  }
  std::sort(scan.stamps.begin(), scan.stamps.end(), [](const auto& a, const auto& b) {
    return a.ticks < b.ticks;
  });
  std::string cut = beyond_the_end(*film.container, *film.stream);
  if (cut.empty()) cut = cut_within_a_packet(*film.container);
  if (!cut.empty()) {
    scan.broken = cut;
  } else if (scan.broken.empty() && status != AVERROR_EOF) {
    scan.broken = fmt::format(
        "the file cannot be read after frame {} ({})", scan.stamps.size(), error_text(status));
  } else if (scan.broken.empty()) {
    scan.broken = stops_short(film, spans, scan.stamps);
  }
  return scan;
}

}  // namespace twang::detail
