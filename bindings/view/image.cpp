// PNG through stb_image_write.
#include "view/image.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wall"
#pragma GCC diagnostic ignored "-Wextra"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include "view/output_file.h"

namespace feder::view {

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

}  // namespace feder::view
