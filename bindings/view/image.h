// Pictures in memory and as files.
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <vector>

namespace feder::view {

struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgba;  // top row first

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 4, 255) {}
  std::uint8_t* pixel(int x, int y) {
    return &rgba[4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
  }
  const std::uint8_t* pixel(int x, int y) const { return const_cast<Image*>(this)->pixel(x, y); }
};

// From OpenGL's rows, bottom first, to a picture's; opaque.
void turn_over(Image& image);

// SceneError when the file cannot be written.
void write_png(const Image& image, const std::filesystem::path& file);

// An animated GIF, frame by frame; a palette of 256 colours for each frame, with ordered dithering.
class GifWriter {
 public:
  GifWriter(const std::filesystem::path& file, int width, int height, double frames_per_second);
  ~GifWriter();
  GifWriter(const GifWriter&) = delete;
  GifWriter& operator=(const GifWriter&) = delete;
  void add(const Image& image);
  void close();  // SceneError when the file could not be written

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace feder::view
