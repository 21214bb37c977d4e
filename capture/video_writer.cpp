// SPDX-License-Identifier: GPL-3.0-or-later
#include "capture/video_writer.hpp"

#include "capture/detail/ffmpeg.hpp"
#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "core/text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

namespace twang {
namespace {

using namespace detail;

constexpr int kMaxCrf = 51;
constexpr int kMaxRateTerm = 1001000;  // of the fraction that stands for the rate
constexpr double kMaxFps = 1e6;        // [1/s]
constexpr std::uint8_t kNoChroma = 128;
constexpr int kEncoderThreads = 3;  // of every machine alike, for their number changes the pictures

/// Closes an output container that may be half written.
struct CloseOutput {
  void operator()(AVFormatContext* context) const {
    if (context->pb) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};
using OutputPtr = std::unique_ptr<AVFormatContext, CloseOutput>;

const char* container_of(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension == ".mp4") return "mp4";
  if (extension == ".mov") return "mov";
  if (extension == ".mkv") return "matroska";
  throw InputError(
      fmt::format("{}: extension is '{}', must be .mp4, .mov or .mkv", path.string(), extension));
}

int even(int size) { return size + size % 2; }

/// Weighted red, green and blue, the weights in 1/65536, rounded; whole numbers, for `lround` takes
/// longer than the encoder.
std::uint8_t mixed(const int* rgb, int red, int green, int blue, int offset) {
  const int sum = red * rgb[0] + green * rgb[1] + blue * rgb[2];
  return static_cast<std::uint8_t>(std::clamp(offset + ((sum + 32768) >> 16), 0, 255));
}

/// A picture as one luma and two chroma planes of `frame`, full range, BT.601.
void fill_frame(const Image& image, AVFrame& frame) {
  const auto pixel = [&](int x, int y) {
    const auto column = static_cast<std::ptrdiff_t>(std::min(x, image.width_px - 1));
    const auto row = static_cast<std::ptrdiff_t>(std::min(y, image.height_px - 1));
    return image.pixels.data() + (row * image.width_px + column) * image.channels;
  };
  for (int y = 0; y < frame.height; ++y) {
    std::uint8_t* row = frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0];
    for (int x = 0; x < frame.width; ++x) {
      const std::uint8_t* p = pixel(x, y);
      if (image.channels == 1) {
        row[x] = p[0];
        continue;
      }
      const int rgb[3] = {p[0], p[1], p[2]};
      row[x] = mixed(rgb, 19595, 38470, 7471, 0);  // 0.299, 0.587, 0.114
    }
  }
  for (int y = 0; y < frame.height / 2; ++y) {
    std::uint8_t* blue = frame.data[1] + static_cast<std::ptrdiff_t>(y) * frame.linesize[1];
    std::uint8_t* red = frame.data[2] + static_cast<std::ptrdiff_t>(y) * frame.linesize[2];
    for (int x = 0; x < frame.width / 2; ++x) {
      if (image.channels == 1) {
        blue[x] = red[x] = kNoChroma;
        continue;
      }
      int rgb[3] = {0, 0, 0};
      for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
        const std::uint8_t* p = pixel(2 * x + dx, 2 * y + dy);
        for (int c = 0; c < 3; ++c) rgb[c] += p[c];
      }
      // A quarter of -0.168736, -0.331264, 0.5; and of 0.5, -0.418688, -0.081312.
      blue[x] = mixed(rgb, -2765, -5427, 8192, kNoChroma);
      red[x] = mixed(rgb, 8192, -6860, -1332, kNoChroma);
    }
  }
}

}  // namespace

void VideoWriterOptions::check() const {
  if (!(fps > 0.0 && fps <= kMaxFps)) {
    throw InputError(fmt::format("fps is {}, must be > 0 and at most {}", fps, kMaxFps));
  }
  if (crf < 0 || crf > kMaxCrf) {
    throw InputError(fmt::format("crf is {}, must be 0 (lossless) to {}", crf, kMaxCrf));
  }
  if (capture_fps_tag && !(*capture_fps_tag > 0.0 && std::isfinite(*capture_fps_tag))) {
    throw InputError(fmt::format("capture_fps_tag is {}, must be > 0", *capture_fps_tag));
  }
}

struct VideoWriter::Impl {
  std::filesystem::path path;
  int width_px = 0;
  int height_px = 0;
  AtomicFile file;  // outlives the container, which writes into it
  OutputPtr container;
  AVStream* stream = nullptr;
  CodecContextPtr codec;
  FramePtr frame{av_frame_alloc()};
  PacketPtr packet{av_packet_alloc()};
  std::int64_t num_written = 0;

  Impl(const std::filesystem::path& target, int width, int height)
      : path(target), width_px(width), height_px(height), file(target) {}

  void check(int status) const {
    if (status >= 0) return;
    throw InputError(fmt::format("{}: cannot be written ({})", path.string(), error_text(status)));
  }

  void open_encoder(const VideoWriterOptions& options) {
    const AVCodec* encoder = avcodec_find_encoder_by_name("libx264");
    if (!encoder) {
      throw InputError(
          fmt::format("{}: cannot be written: FFmpeg was built without libx264", path.string()));
    }
    codec.reset(avcodec_alloc_context3(encoder));
    codec->width = even(width_px);
    codec->height = even(height_px);
    codec->pix_fmt = AV_PIX_FMT_YUV420P;
    codec->color_range = AVCOL_RANGE_JPEG;
    codec->colorspace = AVCOL_SPC_SMPTE170M;
    codec->framerate = av_d2q(options.fps, kMaxRateTerm);
    codec->time_base = av_inv_q(codec->framerate);
    codec->thread_count = kEncoderThreads;
    // x264 spreads its bits by its macroblock tree, and what its AVX-512 routines for that tree
    // give differs from run to run (version 164).
    if (av_get_cpu_flags() & AV_CPU_FLAG_AVX512) {
      check(av_opt_set(codec->priv_data, "x264-params", "asm=avx2", 0));
    }
    // Without loss, effort buys nothing but size.
    const bool quick = options.quick || options.crf == 0;
    if (quick) check(av_opt_set(codec->priv_data, "preset", "ultrafast", 0));
    if (container->oformat->flags & AVFMT_GLOBALHEADER) {
      codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    }
    if (options.crf == 0) {
      check(av_opt_set_int(codec->priv_data, "qp", 0, 0));
    } else {
      check(av_opt_set_double(codec->priv_data, "crf", options.crf, 0));
    }
    check(avcodec_open2(codec.get(), encoder, nullptr));
  }

  void open_container(const char* format, const VideoWriterOptions& options) {
    AVFormatContext* raw = nullptr;
    const std::string url = "file:" + file.temporary_path().string();
    check(avformat_alloc_output_context2(&raw, nullptr, format, url.c_str()));
    container.reset(raw);
    raw->flags |= AVFMT_FLAG_BITEXACT;  // the same pictures make the same file
    open_encoder(options);
    stream = avformat_new_stream(raw, nullptr);
    check(stream ? 0 : AVERROR(ENOMEM));
    check(avcodec_parameters_from_context(stream->codecpar, codec.get()));
    stream->time_base = codec->time_base;
    stream->avg_frame_rate = codec->framerate;
    check(avio_open(&raw->pb, url.c_str(), AVIO_FLAG_WRITE));
    AVDictionary* muxer = nullptr;
    std::string flags = "+faststart";
    if (options.capture_fps_tag) {
      flags += "+use_metadata_tags";
      av_dict_set(&raw->metadata,
                  "com.android.capture.fps",
                  exact_text(*options.capture_fps_tag).c_str(),
                  0);
    }
    av_dict_set(&muxer, "movflags", flags.c_str(), 0);
    const int status = avformat_write_header(raw, &muxer);
    av_dict_free(&muxer);
    check(status);
  }

  /// The frame to be filled and encoded next.
  AVFrame& next_frame() {
    if (!frame->buf[0]) {
      frame->width = codec->width;
      frame->height = codec->height;
      frame->format = codec->pix_fmt;
      frame->color_range = codec->color_range;
      check(av_frame_get_buffer(frame.get(), 0));
    }
    check(av_frame_make_writable(frame.get()));
    return *frame;
  }

  void encode_next() {
    frame->pts = num_written++;
    encode(frame.get());
  }

  void encode(const AVFrame* picture) {
    check(avcodec_send_frame(codec.get(), picture));
    while (true) {
      const int status = avcodec_receive_packet(codec.get(), packet.get());
      if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return;
      check(status);
      packet->stream_index = stream->index;
      packet->duration = 1;
      av_packet_rescale_ts(packet.get(), codec->time_base, stream->time_base);
      check(av_interleaved_write_frame(container.get(), packet.get()));
    }
  }
};

VideoWriter::VideoWriter(const std::filesystem::path& path,
                         int width_px,
                         int height_px,
                         VideoWriterOptions options) {
  silence_ffmpeg();
  options.check();
  const char* format = container_of(path);
  if (width_px < 1 || height_px < 1) {
    throw InputError(fmt::format("{}: picture is {} x {} px, must be at least 1 x 1 px",
                                 path.string(),
                                 width_px,
                                 height_px));
  }
  m_impl = std::make_unique<Impl>(path, width_px, height_px);
  m_impl->open_container(format, options);
}

VideoWriter::~VideoWriter() = default;

void VideoWriter::write(const Image& image) {
  Impl& self = *m_impl;
  assert(self.container);
  const bool fits = image.width_px == self.width_px && image.height_px == self.height_px &&
                    (image.channels == 1 || image.channels == 3) &&
                    image.pixels.size() == static_cast<std::size_t>(image.width_px) *
                                               static_cast<std::size_t>(image.height_px) *
                                               static_cast<std::size_t>(image.channels);
  if (!fits) {
    throw InputError(fmt::format(
        "{}: picture {} is {} x {} px with {} channels, must be {} x {} px, grey or RGB",
        self.path.string(),
        self.num_written + 1,
        image.width_px,
        image.height_px,
        image.channels,
        self.width_px,
        self.height_px));
  }
  fill_frame(image, self.next_frame());
  self.encode_next();
}

void VideoWriter::write(const std::function<void(const PicturePlanes&)>& paint) {
  assert(m_impl->container);
  const AVFrame& frame = m_impl->next_frame();
  paint({frame.data[0],
         frame.data[1],
         frame.data[2],
         frame.linesize[0],
         frame.linesize[1],
         frame.width,
         frame.height});
  m_impl->encode_next();
}

void VideoWriter::finish() {
  Impl& self = *m_impl;
  assert(self.container);
  if (self.num_written == 0) {
    throw InputError(
        fmt::format("{}: has no pictures, must have at least one", self.path.string()));
  }
  self.encode(nullptr);
  self.check(av_write_trailer(self.container.get()));
  avio_flush(self.container->pb);
  self.check(self.container->pb->error);
  self.check(avio_closep(&self.container->pb));
  self.container.reset();
  self.file.commit();
}

}  // namespace twang
