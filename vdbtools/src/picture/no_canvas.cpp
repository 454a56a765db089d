// SPDX-License-Identifier: Apache-2.0
// The canvas of a build without Cairo (JULIAVDB_PICTURES): whoever wants to draw learns why that is not possible.
#include "vdbtools/picture/canvas.h"

#include "vdbtools/base/errors.h"

namespace vdbtools {

struct Canvas::State {};

Canvas::Canvas(CanvasKind, int, int, const Colour&) {
  throw IoError("this program was built without what draws pictures: " VDBTOOLS_NO_PICTURES);
}
Canvas::~Canvas() = default;
Canvas::Canvas(Canvas&&) noexcept = default;
Canvas& Canvas::operator=(Canvas&&) noexcept = default;

int Canvas::width() const { return 0; }
int Canvas::height() const { return 0; }
void Canvas::fill(const CanvasBox&, const Colour&, double) {}
void Canvas::fill(std::span<const CanvasPoint>, const Colour&, double) {}
void Canvas::line(std::span<const CanvasPoint>, const LineStyle&) {}
void Canvas::text(std::string_view, const CanvasPoint&, const TextStyle&) {}
double Canvas::textWidth(std::string_view, const TextStyle&) const { return 0; }
void Canvas::image(const Image&, int, int) {}
bool Canvas::png(std::string_view, const CanvasBox&) { return false; }
Image Canvas::pixels() const { return {}; }
std::string Canvas::encode(const std::string&) { return {}; }

}  // namespace vdbtools
