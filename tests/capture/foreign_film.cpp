// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/capture/foreign_film.hpp"

#include "capture/detail/ffmpeg.hpp"

#include <cstring>
#include <stdexcept>

namespace twang::test {
namespace {

using namespace detail;

constexpr int kWidth = 64;
constexpr int kHeight = 48;

void require(int status, const char* what) {
  if (status < 0) throw std::runtime_error(std::string(what) + ": " + error_text(status));
}

struct CloseOutput {
  void operator()(AVFormatContext* context) const {
    if (context->pb) avio_closep(&context->pb);
    avformat_free_context(context);
  }
};
using OutputPtr = std::unique_ptr<AVFormatContext, CloseOutput>;

OutputPtr open_output(const std::filesystem::path& path) {
  silence_ffmpeg();
  AVFormatContext* raw = nullptr;
  require(avformat_alloc_output_context2(&raw, nullptr, nullptr, path.c_str()), "container");
  OutputPtr output(raw);
  require(avio_open(&raw->pb, path.c_str(), AVIO_FLAG_WRITE), "file");
  return output;
}

/// Takes what packets the encoder has; returns them in order of decoding.
void drain(AVCodecContext& codec, std::vector<PacketPtr>& packets) {
  while (true) {
    PacketPtr packet(av_packet_alloc());
    const int status = avcodec_receive_packet(&codec, packet.get());
    if (status == AVERROR(EAGAIN) || status == AVERROR_EOF) return;
    require(status, "encoding");
    packets.push_back(std::move(packet));
  }
}

CodecContextPtr open_encoder(const ForeignFilm& film, bool global_header) {
  const AVCodec* encoder = avcodec_find_encoder_by_name(film.codec.c_str());
  require(encoder ? 0 : AVERROR_ENCODER_NOT_FOUND, film.codec.c_str());
  CodecContextPtr codec(avcodec_alloc_context3(encoder));
  codec->width = kWidth;
  codec->height = kHeight;
  codec->pix_fmt = av_get_pix_fmt(film.pixel_format.c_str());
  codec->time_base = {1, film.ticks_per_s};
  codec->strict_std_compliance = FF_COMPLIANCE_EXPERIMENTAL;
  codec->color_range = AVCOL_RANGE_JPEG;
  if (film.codec == "libx264") {
    // Fine enough to keep an even level, but not the lossless mode, which has no B pictures.
    av_opt_set_int(codec->priv_data, "qp", 1, 0);
    av_opt_set(codec->priv_data, "x264-params", "b-adapt=0:bframes=3:scenecut=0", 0);
  }
  if (global_header) codec->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
  require(avcodec_open2(codec.get(), encoder, nullptr), "encoder");
  return codec;
}

/// An even picture. More than 8 bits: the level's remaining bits count pictures.
void fill(AVFrame& frame, int n) {
  const auto* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const AVComponentDescriptor& luma = format->comp[0];
  for (int plane = 0; plane < 4 && frame.buf[plane]; ++plane) {
    std::uint8_t* bytes = frame.buf[plane]->data;
    const std::size_t size = frame.buf[plane]->size;
    if (luma.depth == 8) {
      std::memset(bytes, plane == 0 ? picture_level(n) : 128, size);
      if (plane > 0 || luma.step == 1) continue;
      for (std::size_t i = 1 - static_cast<std::size_t>(luma.offset); i < size; i += 2) {
        bytes[i] = 128;  // the chroma between the luma
      }
      continue;
    }
    const int surplus = luma.depth - 8;
    const int level =
        plane == 0 ? (picture_level(n) << surplus) + n % (1 << surplus) : 128 << surplus;
    const bool big = (format->flags & AV_PIX_FMT_FLAG_BE) != 0;
    for (std::size_t i = 0; i + 1 < size; i += 2) {
      const int sample = level << luma.shift;
      bytes[i] = static_cast<std::uint8_t>(big ? sample >> 8 : sample);
      bytes[i + 1] = static_cast<std::uint8_t>(big ? sample : sample >> 8);
    }
  }
}

std::vector<PacketPtr> encode(AVCodecContext& codec, const ForeignFilm& film) {
  std::vector<PacketPtr> packets;
  for (std::size_t n = 0; n < film.stamps.size(); ++n) {
    const FramePtr frame(av_frame_alloc());
    frame->width = kWidth;
    frame->height = kHeight;
    frame->format = codec.pix_fmt;
    require(av_frame_get_buffer(frame.get(), 0), "frame");
    fill(*frame, static_cast<int>(n));
    frame->pts = film.stamps[n];
    require(avcodec_send_frame(&codec, frame.get()), "encoding");
    drain(codec, packets);
  }
  require(avcodec_send_frame(&codec, nullptr), "encoding");
  drain(codec, packets);
  return packets;
}

}  // namespace

int picture_level(int n) { return 40 + n % 180; }

void write_foreign_film(const std::filesystem::path& path, const ForeignFilm& film) {
  const OutputPtr output = open_output(path);
  const CodecContextPtr codec = open_encoder(film, output->oformat->flags & AVFMT_GLOBALHEADER);
  AVStream* stream = avformat_new_stream(output.get(), nullptr);
  require(avcodec_parameters_from_context(stream->codecpar, codec.get()), "stream");
  stream->time_base = codec->time_base;
  AVDictionary* options = nullptr;
  if (film.faststart) av_dict_set(&options, "movflags", "+faststart", 0);
  const int header = avformat_write_header(output.get(), &options);
  av_dict_free(&options);
  require(header, "header");
  const std::vector<PacketPtr> packets = encode(*codec, film);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    AVPacket& packet = *packets[i];
    const std::size_t count = film.stamps.size();
    if (count > 1) packet.duration = film.stamps[count - 1] - film.stamps[count - 2];
    if (film.reordering_lost) packet.pts = packet.dts = film.stamps[i];
    av_packet_rescale_ts(&packet, codec->time_base, stream->time_base);
    require(av_interleaved_write_frame(output.get(), &packet), "writing");
  }
  require(av_write_trailer(output.get()), "trailer");
}

void write_sound_file(const std::filesystem::path& path) {
  const OutputPtr output = open_output(path);
  AVStream* stream = avformat_new_stream(output.get(), nullptr);
  AVCodecParameters& sound = *stream->codecpar;
  sound.codec_type = AVMEDIA_TYPE_AUDIO;
  sound.codec_id = AV_CODEC_ID_PCM_S16LE;
  sound.format = AV_SAMPLE_FMT_S16;
  sound.sample_rate = 8000;
  sound.bits_per_coded_sample = 16;
  sound.block_align = 2;
  av_channel_layout_default(&sound.ch_layout, 1);
  stream->time_base = {1, sound.sample_rate};
  require(avformat_write_header(output.get(), nullptr), "header");
  for (int block = 0; block < 8; ++block) {
    const PacketPtr packet(av_packet_alloc());
    require(av_new_packet(packet.get(), 2000), "packet");
    std::memset(packet->data, 17 * block, 2000);
    packet->pts = packet->dts = 1000 * block;
    packet->duration = 1000;
    av_packet_rescale_ts(packet.get(), {1, sound.sample_rate}, stream->time_base);
    require(av_interleaved_write_frame(output.get(), packet.get()), "writing");
  }
  require(av_write_trailer(output.get()), "trailer");
}

std::string colour_range_of(const std::filesystem::path& path) {
  silence_ffmpeg();
  AVFormatContext* raw = nullptr;
  require(avformat_open_input(&raw, path.c_str(), nullptr, nullptr), "opening");
  const InputPtr input(raw);
  require(avformat_find_stream_info(raw, nullptr), "opening");
  const char* name = av_color_range_name(raw->streams[0]->codecpar->color_range);
  return name ? name : "";
}

std::vector<std::uint8_t> decode_png(std::vector<std::uint8_t> bytes,
                                     const std::string& pixel_format) {
  silence_ffmpeg();
  const AVCodec* decoder = avcodec_find_decoder(AV_CODEC_ID_PNG);
  const CodecContextPtr codec(avcodec_alloc_context3(decoder));
  require(avcodec_open2(codec.get(), decoder, nullptr), "decoder");
  const PacketPtr packet(av_packet_alloc());
  require(av_new_packet(packet.get(), static_cast<int>(bytes.size())), "packet");
  std::memcpy(packet->data, bytes.data(), bytes.size());
  require(avcodec_send_packet(codec.get(), packet.get()), "decoding");
  const FramePtr frame(av_frame_alloc());
  require(avcodec_receive_frame(codec.get(), frame.get()), "decoding");
  if (frame->format != av_get_pix_fmt(pixel_format.c_str())) {
    throw std::runtime_error("pixel format is not " + pixel_format);
  }
  const int row = av_image_get_linesize(codec->pix_fmt, frame->width, 0);
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < frame->height; ++y) {
    const std::uint8_t* begin =
        frame->data[0] + static_cast<std::ptrdiff_t>(y) * frame->linesize[0];
    pixels.insert(pixels.end(), begin, begin + row);
  }
  return pixels;
}

}  // namespace twang::test
