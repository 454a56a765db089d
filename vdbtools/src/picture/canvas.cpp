// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/picture/canvas.h"

#include "base/srgb.h"
#include "picture/embedded_fonts.h"
#include "picture/svg_drawing.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/files/file_bytes.h"

#include <cairo-ft.h>
#include <cairo.h>
#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_MODULE_H
#include FT_OUTLINE_H
#include FT_SYSTEM_H

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

struct Destroy {
  void operator()(cairo_t* context) const { cairo_destroy(context); }
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_font_options_t* options) const { cairo_font_options_destroy(options); }
};
template <class Object>
using Owned = std::unique_ptr<Object, Destroy>;

void require(cairo_status_t status) {
  if (status == CAIRO_STATUS_NO_MEMORY) throw std::bad_alloc();
  if (status != CAIRO_STATUS_SUCCESS)
    throw IoError(std::string("Cairo cannot draw: ") + cairo_status_to_string(status));
}

/// Reads from the string_view to which @a rest points, and advances it.
cairo_status_t take(void* rest, unsigned char* data, unsigned int length) {
  auto& bytes = *static_cast<std::string_view*>(rest);
  if (bytes.size() < length) return CAIRO_STATUS_READ_ERROR;
  std::copy_n(bytes.begin(), length, data);
  bytes.remove_prefix(length);
  return CAIRO_STATUS_SUCCESS;
}

/// The pixels of a row of an RGB24 surface.
std::uint32_t* rowOf(cairo_surface_t* surface, int y) {
  return reinterpret_cast<std::uint32_t*>(cairo_image_surface_get_data(surface) +
                                          static_cast<std::ptrdiff_t>(y) * cairo_image_surface_get_stride(surface));
}

void require(FT_Error error) {
  if (error == FT_Err_Out_Of_Memory) throw std::bad_alloc();
  if (error != FT_Err_Ok) throw IoError("FreeType cannot read the font of the program: error " + std::to_string(error));
}

/// A font that does not depend on Fontconfig or on FreeType's environment. Cairo keeps references to fonts, so they
/// stay until the process ends. Each font has a FreeType library of its own, because Cairo serialises the use of a
/// font, but not of a FreeType library.
class Font {
 public:
  explicit Font(bool isBold) {
    require(FT_New_Library(&mMemory, &mLibrary));
    try {
      FT_Add_Default_Modules(mLibrary);
      const std::span<const unsigned char> file = embeddedFont(isBold);
      FT_Face face = nullptr;
      require(FT_New_Memory_Face(mLibrary, file.data(), static_cast<FT_Long>(file.size()), 0, &face));
      mFont = cairo_ft_font_face_create_for_ft_face(face, 0);
      require(cairo_font_face_status(mFont));
    } catch (...) {
      FT_Done_Library(mLibrary);
      throw;
    }
  }
  cairo_font_face_t* get() const { return mFont; }

 private:
  FT_MemoryRec_ mMemory{
      nullptr, [](FT_Memory, long size) { return std::malloc(static_cast<std::size_t>(size)); },
      [](FT_Memory, void* block) { std::free(block); },
      [](FT_Memory, long, long size, void* block) { return std::realloc(block, static_cast<std::size_t>(size)); }};
  FT_Library mLibrary = nullptr;
  cairo_font_face_t* mFont = nullptr;
};

cairo_font_face_t* fontOf(const TextStyle& style) {
  static const Font* const regular = new Font(false);
  static const Font* const bold = new Font(true);
  return (style.bold ? bold : regular)->get();
}

struct DestroyGlyphs {
  void operator()(cairo_glyph_t* glyphs) const { cairo_glyph_free(glyphs); }
};

/// The glyphs of a text in UTF-8, from a point on.
struct Glyphs {
  Glyphs(cairo_scaled_font_t* font, std::string_view utf8, double x, double y) {
    cairo_glyph_t* made = nullptr;
    require(cairo_scaled_font_text_to_glyphs(font, x, y, std::string(utf8).c_str(), -1, &made, &count, nullptr, nullptr,
                                             nullptr));
    first.reset(made);
  }
  std::span<cairo_glyph_t> all() const { return {first.get(), static_cast<std::size_t>(count)}; }

  std::unique_ptr<cairo_glyph_t, DestroyGlyphs> first;
  int count = 0;
};

/// Outlines of glyphs, as commands of an SVG path in units of the font.
struct Outline {
  std::string path;
  FT_Pos left = 0;  ///< of the glyph that is added

  FT_Error add(char command, std::initializer_list<const FT_Vector*> points) {
    // An exception must not pass through FreeType, which is written in C.
    try {
      path += command;
      const char* gap = "";
      for (const FT_Vector* point : points) {
        path += gap + std::to_string(left + point->x) + ' ' + std::to_string(point->y);
        gap = " ";
      }
      return FT_Err_Ok;
    } catch (const std::bad_alloc&) {
      return FT_Err_Out_Of_Memory;
    }
  }

  void add(FT_Outline& glyph) {
    FT_Outline_Funcs functions{};
    functions.move_to = [](const FT_Vector* to, void* outline) { return its(outline).add('M', {to}); };
    functions.line_to = [](const FT_Vector* to, void* outline) { return its(outline).add('L', {to}); };
    functions.conic_to = [](const FT_Vector* control, const FT_Vector* to, void* outline) {
      return its(outline).add('Q', {control, to});
    };
    functions.cubic_to = [](const FT_Vector* first, const FT_Vector* second, const FT_Vector* to, void* outline) {
      return its(outline).add('C', {first, second, to});
    };
    require(FT_Outline_Decompose(&glyph, &functions, this));
  }

 private:
  static Outline& its(void* outline) { return *static_cast<Outline*>(outline); }
};

/// Lends the FreeType face of a font of Cairo to one thread.
class LentFace {
 public:
  explicit LentFace(cairo_scaled_font_t* font) : mFont(font), mFace(cairo_ft_scaled_font_lock_face(font)) {
    require(cairo_scaled_font_status(font));
    if (!mFace) throw std::bad_alloc();
  }
  ~LentFace() { cairo_ft_scaled_font_unlock_face(mFont); }
  LentFace(const LentFace&) = delete;
  LentFace& operator=(const LentFace&) = delete;
  FT_Face operator->() const { return mFace; }
  FT_Face get() const { return mFace; }

 private:
  cairo_scaled_font_t* mFont;
  FT_Face mFace;
};

}  // namespace

struct Canvas::State {
  CanvasKind kind;
  int width, height;
  std::optional<SvgDrawing> svg;  ///< Cairo only measures text then
  Owned<cairo_surface_t> surface;
  Owned<cairo_t> context;

  void setColour(const Colour& colour, double opacity = 1) const {
    const auto channel = [&](std::size_t i) { return srgbCode(colour[i]) / 255.0; };
    cairo_set_source_rgba(context.get(), channel(0), channel(1), channel(2), opacity);
  }
  void setFont(const TextStyle& style) const {
    cairo_set_font_face(context.get(), fontOf(style));
    cairo_set_font_size(context.get(), style.size);
  }
  void paint(cairo_surface_t* image, const CanvasBox& box) const {
    cairo_set_source_surface(context.get(), image, box.left, box.top);
    cairo_pattern_set_filter(cairo_get_source(context.get()), CAIRO_FILTER_NEAREST);
    cairo_rectangle(context.get(), box.left, box.top, box.width, box.height);
    cairo_fill(context.get());
  }

  /// Draws the text from the current point on.
  void show(std::string_view utf8) const {
    cairo_t* const cairo = context.get();
    CanvasPoint start;
    cairo_get_current_point(cairo, &start.x, &start.y);
    const Glyphs glyphs(cairo_get_scaled_font(cairo), utf8, start.x, start.y);
    // Glyphs are placed on whole pixels, because Cairo 1.16 always does so, while later releases accept any position.
    for (cairo_glyph_t& glyph : glyphs.all()) {
      cairo_user_to_device(cairo, &glyph.x, &glyph.y);
      glyph.x = std::floor(glyph.x + 0.5);
      glyph.y = std::floor(glyph.y + 0.5);
      cairo_device_to_user(cairo, &glyph.x, &glyph.y);
    }
    cairo_show_glyphs(cairo, glyphs.first.get(), glyphs.count);
  }

  /// The outlines are those of the font at its own size: they are whole numbers, which no library rounds.
  void showInSvg(std::string_view utf8, const CanvasPoint& origin, const TextStyle& style) {
    cairo_scaled_font_t* const font = cairo_get_scaled_font(context.get());
    const Glyphs glyphs(font, utf8, 0, 0);
    Outline outline;
    double unit = 0;
    {
      const LentFace face(font);
      for (const cairo_glyph_t& glyph : glyphs.all()) {
        require(FT_Load_Glyph(face.get(), static_cast<FT_UInt>(glyph.index), FT_LOAD_NO_SCALE));
        outline.add(face->glyph->outline);
        outline.left += face->glyph->metrics.horiAdvance;
      }
      unit = style.size / face->units_per_EM;
    }
    if (!outline.path.empty()) svg->text(utf8, outline.path, origin, unit, style);
  }
};

Canvas::Canvas(CanvasKind kind, int width, int height, const Colour& background) {
  constexpr int kLargestSide = 32767;  // the limit of Cairo
  if (width < 1 || height < 1 || width > kLargestSide || height > kLargestSide)
    throw std::invalid_argument("a canvas of " + std::to_string(width) + " x " + std::to_string(height) +
                                " pixels cannot be made; each side must be 1 to " + std::to_string(kLargestSide));
  mState = std::make_unique<State>(State{kind, width, height, std::nullopt, {}, {}});
  if (kind == CanvasKind::Svg) {
    mState->svg.emplace(width, height);
    mState->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, 1, 1));
  } else {
    // Codes of Cairo, then colours as floats and codes for the file.
    constexpr double kBytesOfPixel = 19;
    requireMemory(kBytesOfPixel * width * height, MemoryUse::Picture,
                  "a page of " + std::to_string(width) + " x " + std::to_string(height) + " pixels");
    mState->surface.reset(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height));
  }
  require(cairo_surface_status(mState->surface.get()));
  mState->context.reset(cairo_create(mState->surface.get()));
  cairo_t* const context = mState->context.get();
  require(cairo_status(context));
  // Cairo's default options are those of the surface.
  const Owned<cairo_font_options_t> font(cairo_font_options_create());
  cairo_font_options_set_antialias(font.get(), CAIRO_ANTIALIAS_GRAY);
  cairo_font_options_set_hint_style(font.get(), CAIRO_HINT_STYLE_SLIGHT);
  cairo_font_options_set_hint_metrics(font.get(), CAIRO_HINT_METRICS_OFF);
  cairo_set_font_options(context, font.get());
  cairo_set_line_cap(context, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(context, CAIRO_LINE_JOIN_ROUND);
  cairo_set_fill_rule(context, CAIRO_FILL_RULE_EVEN_ODD);
  fill({0, 0, static_cast<double>(width), static_cast<double>(height)}, background);
}

Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

int Canvas::width() const { return mState->width; }
int Canvas::height() const { return mState->height; }

void Canvas::fill(const CanvasBox& box, const Colour& colour, double opacity) {
  if (mState->svg) return mState->svg->fill(box, colour, opacity);
  mState->setColour(colour, opacity);
  cairo_rectangle(mState->context.get(), box.left, box.top, box.width, box.height);
  cairo_fill(mState->context.get());
}

void Canvas::fill(std::span<const CanvasPoint> polygon, const Colour& colour, double opacity) {
  if (mState->svg) return mState->svg->fill(polygon, colour, opacity);
  mState->setColour(colour, opacity);
  for (const CanvasPoint& point : polygon) cairo_line_to(mState->context.get(), point.x, point.y);
  cairo_fill(mState->context.get());
}

void Canvas::line(std::span<const CanvasPoint> points, const LineStyle& style) {
  if (points.empty()) return;
  if (mState->svg) return mState->svg->line(points, style);
  cairo_t* const context = mState->context.get();
  mState->setColour(style.colour);
  cairo_set_line_width(context, style.width);
  // Each segment has round ends of its own, which together make round corners; Cairo's own corners differ from release
  // to release. All segments form one path, so overlaps are drawn once.
  for (std::size_t i = 0; i + 1 < std::max<std::size_t>(points.size(), 2); ++i) {
    const CanvasPoint &from = points[i], &to = points[std::min(i + 1, points.size() - 1)];
    cairo_move_to(context, from.x, from.y);
    cairo_line_to(context, to.x, to.y);
  }
  cairo_stroke(context);
}

void Canvas::text(std::string_view utf8, const CanvasPoint& at, const TextStyle& style) {
  cairo_t* const context = mState->context.get();
  const double length = textWidth(utf8, style);
  const double back = style.align == TextAlign::Left ? 0 : style.align == TextAlign::Right ? length : length / 2;
  if (cairo_status(context) != CAIRO_STATUS_SUCCESS)
    return;  // for example because the text is not UTF-8; encode() and pixels() report it
  if (mState->svg)
    return mState->showInSvg(utf8, style.upwards ? CanvasPoint{at.x, at.y + back} : CanvasPoint{at.x - back, at.y},
                             style);
  mState->setColour(style.colour);
  cairo_save(context);
  cairo_translate(context, at.x, at.y);
  constexpr cairo_matrix_t kUpwards{0, -1, 1, 0, 0, 0};  // avoids the rounding of a sine and a cosine
  if (style.upwards) cairo_transform(context, &kUpwards);
  cairo_move_to(context, -back, 0);
  mState->show(utf8);
  cairo_restore(context);
  cairo_new_path(context);
}

double Canvas::textWidth(std::string_view utf8, const TextStyle& style) const {
  mState->setFont(style);
  cairo_text_extents_t extents;
  cairo_text_extents(mState->context.get(), std::string(utf8).c_str(), &extents);
  return extents.x_advance;
}

void Canvas::image(const Image& image, int left, int top) {
  const CanvasBox box{static_cast<double>(left), static_cast<double>(top), static_cast<double>(image.width),
                      static_cast<double>(image.height)};
  if (mState->svg) return mState->svg->image(encodeImage(image, "png"), box);
  const Owned<cairo_surface_t> source(cairo_image_surface_create(CAIRO_FORMAT_RGB24, image.width, image.height));
  require(cairo_surface_status(source.get()));
  cairo_surface_flush(source.get());
  for (int y = 0; y < image.height; ++y) {
    std::uint32_t* const row = rowOf(source.get(), y);
    for (int x = 0; x < image.width; ++x) {
      const Colour& pixel = image.at(x, y);
      row[x] = static_cast<std::uint32_t>(srgbCode(pixel[0])) << 16 |
               static_cast<std::uint32_t>(srgbCode(pixel[1])) << 8 | srgbCode(pixel[2]);
    }
  }
  cairo_surface_mark_dirty(source.get());
  mState->paint(source.get(), box);
}

bool Canvas::png(std::string_view bytes, const CanvasBox& box) {
  std::string_view rest = bytes;
  const Owned<cairo_surface_t> source(cairo_image_surface_create_from_png_stream(take, &rest));
  if (cairo_surface_status(source.get()) != CAIRO_STATUS_SUCCESS ||
      cairo_image_surface_get_width(source.get()) != box.width ||
      cairo_image_surface_get_height(source.get()) != box.height)
    return false;
  if (mState->svg)
    mState->svg->image(bytes, box);
  else
    mState->paint(source.get(), box);
  return true;
}

Image Canvas::pixels() const {
  if (mState->kind != CanvasKind::Pixels) throw std::logic_error("a canvas of SVG has no pixels");
  require(cairo_status(mState->context.get()));
  cairo_surface_t* const surface = mState->surface.get();
  cairo_surface_flush(surface);
  std::array<float, 256> linear;
  for (std::size_t code = 0; code < linear.size(); ++code)
    linear[code] = linearFromSrgb(static_cast<float>(code) / 255);
  Image image(mState->width, mState->height);
  for (int y = 0; y < image.height; ++y) {
    const std::uint32_t* const row = rowOf(surface, y);
    for (int x = 0; x < image.width; ++x)
      image.at(x, y) = {linear[row[x] >> 16 & 0xff], linear[row[x] >> 8 & 0xff], linear[row[x] & 0xff]};
  }
  return image;
}

std::string Canvas::encode(const std::string& extension) {
  if (canvasKindOf(extension) != mState->kind)
    throw std::invalid_argument("this canvas cannot be written as \"" + extension + "\"; it is of the other kind");
  if (mState->kind == CanvasKind::Pixels) return encodeImage(pixels(), extension);
  require(cairo_status(mState->context.get()));
  return mState->svg->bytes();
}

}  // namespace vdbtools
