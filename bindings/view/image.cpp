// PNG through stb_image_write; GIF through giflib.
#include "view/image.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include <gif_lib.h>

#include <algorithm>
#include <cmath>

#include "view/output_file.h"

namespace feder::view {
namespace {

// 4 x 4 Bayer matrix, -7.5 .. 7.5: pushes neighbouring pixels apart by less than a palette step.
constexpr int kBayer[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};

constexpr int kUnchanged = 255;  // the palette's last index

int append(GifFileType* gif, const GifByteType* bytes, int size) {
  auto& out = *static_cast<std::ofstream*>(gif->UserData);
  out.write(reinterpret_cast<const char*>(bytes), size);
  return out ? size : 0;
}

}  // namespace

void turn_over(Image& image) {
  const std::size_t row = std::size_t(4) * static_cast<std::size_t>(image.width);
  for (int y = 0; y < image.height / 2; ++y)
    std::swap_ranges(image.pixel(0, y), image.pixel(0, y) + row, image.pixel(0, image.height - 1 - y));
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
}

void write_png(const Image& image, const std::filesystem::path& file) {
  const auto append = [](void* to, void* data, int size) {
    static_cast<std::ostream*>(to)->write(static_cast<const char*>(data), size);
  };
  // pictures are opaque: three channels do
  std::vector<std::uint8_t> rgb(image.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < image.rgba.size() / 4; ++i)
    for (std::size_t k = 0; k < 3; ++k) rgb[3 * i + k] = image.rgba[4 * i + k];
  write_file(file, [&](std::ostream& out) {
    if (!stbi_write_png_to_func(append, &out, image.width, image.height, 3, rgb.data(), 3 * image.width))
      out.setstate(std::ios::failbit);
  });
}

// GIF: a palette of 255 colours per frame by its median cut, ordered dithering against bands. What has
// not changed since the frame before is transparent, which makes still backgrounds cheap.
struct GifWriter::Impl {
  std::unique_ptr<report::OutputFile> out;
  std::vector<std::uint8_t> before;  // the last frame's pixels
  std::filesystem::path file;
  GifFileType* gif = nullptr;
  int width = 0, height = 0;
  double delay = 0, owed = 0;  // hundredths of a second; what rounding has left
  std::vector<GifByteType> red, green, blue, index;

  [[noreturn]] void fail(int error) const {
    const char* why = GifErrorString(error);
    throw SceneError(file.string() + ": cannot be written" + (why ? std::string(": ") + why : ""));
  }
  void require(int result) const {
    if (result == GIF_ERROR) fail(gif->Error);
  }
};

GifWriter::GifWriter(const std::filesystem::path& file, int width, int height, double frames_per_second)
    : impl_(std::make_unique<Impl>()) {
  Impl& g = *impl_;
  g.file = file, g.width = width, g.height = height, g.delay = 100 / frames_per_second;
  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  g.red.resize(pixels), g.green.resize(pixels), g.blue.resize(pixels), g.index.resize(pixels);
  int error = 0;
  try {
    g.out = std::make_unique<report::OutputFile>(file);
  } catch (const std::runtime_error& e) {
    throw SceneError(e.what());
  }
  g.gif = EGifOpen(&g.out->stream(), append, &error);
  if (!g.gif) g.fail(error);
  EGifSetGifVersion(g.gif, true);
  g.require(EGifPutScreenDesc(g.gif, width, height, 8, 0, nullptr));
  // repeats without end
  const unsigned char loop[] = {1, 0, 0};
  g.require(EGifPutExtensionLeader(g.gif, APPLICATION_EXT_FUNC_CODE));
  g.require(EGifPutExtensionBlock(g.gif, 11, "NETSCAPE2.0"));
  g.require(EGifPutExtensionBlock(g.gif, 3, loop));
  g.require(EGifPutExtensionTrailer(g.gif));
}

GifWriter::~GifWriter() {
  int error = 0;
  if (impl_->gif) EGifCloseFile(impl_->gif, &error);
}

void GifWriter::add(const Image& image) {
  Impl& g = *impl_;
  if (image.width != g.width || image.height != g.height)
    throw SceneError(g.file.string() + ": frames of different sizes");
  for (int y = 0; y < g.height; ++y)
    for (int x = 0; x < g.width; ++x) {
      const std::uint8_t* p = image.pixel(x, y);
      const std::size_t at =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(g.width) + static_cast<std::size_t>(x);
      const int push = (2 * kBayer[y % 4][x % 4] - 15) / 4;
      const auto pushed = [push](int c) { return static_cast<GifByteType>(std::clamp(c + push, 0, 255)); };
      g.red[at] = pushed(p[0]), g.green[at] = pushed(p[1]), g.blue[at] = pushed(p[2]);
    }
  int colors = kUnchanged;
  ColorMapObject* map = GifMakeMapObject(256, nullptr);
  if (!map) g.fail(E_GIF_ERR_NOT_ENOUGH_MEM);
  int result = GifQuantizeBuffer(static_cast<unsigned>(g.width), static_cast<unsigned>(g.height), &colors, g.red.data(),
                                 g.green.data(), g.blue.data(), g.index.data(), map->Colors);
  const bool follows = !g.before.empty();
  for (std::size_t i = 0; follows && i < g.index.size(); ++i)
    if (std::equal(&image.rgba[4 * i], &image.rgba[4 * i + 3], &g.before[4 * i])) g.index[i] = kUnchanged;
  g.before = image.rgba;
  g.owed += g.delay;
  GraphicsControlBlock control{};
  control.DisposalMode = DISPOSE_DO_NOT;
  control.DelayTime = static_cast<int>(std::lround(g.owed));
  control.TransparentColor = follows ? kUnchanged : NO_TRANSPARENT_COLOR;
  g.owed -= control.DelayTime;
  GifByteType bytes[4];
  const std::size_t size = EGifGCBToExtension(&control, bytes);
  if (result != GIF_ERROR) result = EGifPutExtension(g.gif, GRAPHICS_EXT_FUNC_CODE, static_cast<int>(size), bytes);
  if (result != GIF_ERROR) result = EGifPutImageDesc(g.gif, 0, 0, g.width, g.height, false, map);
  GifFreeMapObject(map);
  g.require(result);
  for (int y = 0; y < g.height; ++y)
    g.require(
        EGifPutLine(g.gif, g.index.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(g.width), g.width));
}

void GifWriter::close() {
  Impl& g = *impl_;
  if (!g.gif) return;
  int error = 0;
  const int result = EGifCloseFile(g.gif, &error);
  g.gif = nullptr;
  if (result == GIF_ERROR) g.fail(error);
  try {
    g.out->close();
  } catch (const std::runtime_error& e) {
    throw SceneError(e.what());
  }
}

}  // namespace feder::view
