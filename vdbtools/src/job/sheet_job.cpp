// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/job/sheet_job.h"

#include "base/timed_part.h"
#include "job/mesh_picture.h"
#include "picture/png_text.h"
#include "scene/file_hashes.h"

#include "picture/contact_sheet.h"
#include "vdbtools/base/monitor.h"
#include "vdbtools/base/text.h"
#include "vdbtools/field/lattice_options.h"
#include "vdbtools/files/atomic_file.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/named_file.h"
#include "vdbtools/scene/scene.h"
#include "vdbtools/scene/voxel_advice.h"

#include <tbb/task_arena.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <exception>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

namespace vdbtools {
namespace {

constexpr const char* kCellSize = "256x256";
constexpr const char* kPreview = "preview";
constexpr const char* kMesh = "mesh";
/// The keys under which the PNG of a finished cell stores its caption and SheetCell::finer.
constexpr const char* kFinerCaption = "finer-caption";
constexpr const char* kFiner = "finer";

/// How a cell is shown.
struct CellView {
  FieldPicture field;               ///< with the light
  std::optional<ViewOptions> mesh;  ///< set if the mesh is shown instead
  Recipe recorded{};                ///< complete; identifies a finished cell

  int width() const { return field.render.width; }
  int height() const { return field.render.height; }
};

/// A cell, its failure if there is one, and its picture.
struct PlannedCell {
  SheetCell cell;
  CellView view;
  std::exception_ptr failure{};
  std::string png{};
};

struct Plan {
  Sheet sheet;  ///< without its cells
  std::vector<PlannedCell> cells;
  CellView view;  ///< of every cell, except for the varied options
};

/// Runs the work on a cell. Errors in its options, its set and its files are stored as the failure of the cell; other
/// errors end the whole sheet.
template <class Work>
void guarded(PlannedCell& planned, const Work& work) {
  const auto fail = [&](const std::exception& error) {
    planned.failure = std::current_exception();
    planned.cell.error = inOneLine(error.what());
  };
  try {
    work();
  } catch (const std::invalid_argument& error) {
    fail(error);
  } catch (const DataError& error) {
    fail(error);
  } catch (const MissingInputError& error) {
    fail(error);
  }
}

/// The maximum ratio of a page's sides, if its cells can be laid out in another way.
constexpr std::int64_t kLongestPage = 3;

/// The number of columns of a page that is about square: that number, or a few more, whichever leaves the fewest places
/// empty.
int columnsFor(int cells, int width, int height) {
  constexpr int kMore = 2;
  const auto rowsOf = [&](int columns) { return (cells + columns - 1) / columns; };
  const auto empty = [&](int columns) { return rowsOf(columns) * columns - cells; };
  const double square = std::ceil(std::sqrt(static_cast<double>(cells) * height / width));
  int best = static_cast<int>(std::clamp(square, 1.0, static_cast<double>(cells)));
  for (int columns = best + 1, most = std::min(best + kMore, cells); columns <= most; ++columns)
    if (empty(columns) < empty(best) &&
        std::int64_t{columns} * width <= kLongestPage * rowsOf(columns) * std::int64_t{height})
      best = columns;
  return best;
}

/// The number of rows that each value of the first of two varied options takes.
int rowsOfEach(const Sheet& sheet) {
  if (sheet.varied.size() == 1) return 1;
  const auto count = static_cast<int>(sheet.varied[1].values.size());
  return (count + sheet.columns - 1) / sheet.columns;
}

/// The place of a cell on the page, counted row by row.
int placeOf(const Sheet& sheet, int cell) {
  if (sheet.varied.size() == 1) return cell;
  const auto count = static_cast<int>(sheet.varied[1].values.size());
  // Several values of the first option may share a row, or one of them fill several.
  return sheet.columns >= count ? cell : cell / count * rowsOfEach(sheet) * sheet.columns + cell % count;
}

/// Lays out two options: each value of the first has a row, and each value of the second a column. If the page would be
/// too wide, each value of the first has several rows; if it would be too high, several of them share a row.
void layOutPairs(int first, int second, int width, int height, Sheet& sheet) {
  const auto isStrip = [&](std::int64_t one, int size, std::int64_t other, int otherSize) {
    return one * size > kLongestPage * other * otherSize;
  };
  const auto ceiling = [](int count, int parts) { return (count + parts - 1) / parts; };
  int folds = 1, groups = 1;
  while (ceiling(second, folds) > 1 && isStrip(ceiling(second, folds), width, std::int64_t{first} * folds, height))
    ++folds;
  while (groups < first && isStrip(ceiling(first, groups), height, std::int64_t{groups} * second, width)) ++groups;
  if (folds > 1) groups = 1;
  sheet.columns = groups * ceiling(second, folds);
  sheet.rows = ceiling(first, groups) * ceiling(second, ceiling(second, folds));
}

/// @param width, height  of a cell's picture, pixels
void layOut(const SheetOptions& options, int width, int height, Sheet& sheet) {
  const std::vector<VariedOption>& varied = options.varied;
  const auto count = [&](std::size_t i) { return static_cast<int>(varied[i].values.size()); };
  if (options.columns && varied.size() != 1)
    throw std::invalid_argument("--columns is " + std::to_string(*options.columns) +
                                "; it goes with one varied option only, for the values of the second are the columns");
  if (varied.size() == 2 && count(0) > 1 && count(1) > 1) return layOutPairs(count(0), count(1), width, height, sheet);
  const int cells = varied.size() == 1 ? count(0) : count(0) * count(1);
  sheet.columns = std::min(options.columns.value_or(columnsFor(cells, width, height)), cells);
  sheet.rows = (cells + sheet.columns - 1) / sheet.columns;
}

void requireVaried(const SheetOptions& options) {
  const std::vector<VariedOption>& varied = options.varied;
  if (varied.empty())
    throw std::invalid_argument("nothing varies; use --vary NAME=VALUES, such as --vary alpha=10,20,40");
  if (varied.size() > 2)
    throw std::invalid_argument("--vary is given " + std::to_string(varied.size()) +
                                " times; a sheet has rows and columns, so vary one option or two");
  if (varied.size() == 2 && varied[0].name == varied[1].name)
    throw std::invalid_argument("--vary is given twice for '" + varied[0].name + "'; give all its values at once");
  for (const VariedOption& option : varied)
    if (options.given.contains(option.name) || options.view.contains(option.name))
      throw std::invalid_argument("--" + option.name + " is given and varied; give only one of them");
  std::size_t cells = 1;
  for (const VariedOption& option : varied) cells *= option.values.size();
  if (cells > kMostSheetCells)
    throw std::invalid_argument("the sheet would have " + std::to_string(cells) + " cells; it may have " +
                                std::to_string(kMostSheetCells) + ", so vary fewer values");
}

/// The varied options of each cell, row by row.
std::vector<Recipe> combinations(const std::vector<VariedOption>& varied) {
  std::vector<Recipe> cells{{}};
  for (const VariedOption& option : varied) {
    std::vector<Recipe> finer;
    for (const Recipe& cell : cells)
      for (const std::string& value : option.values) finer.emplace_back(cell)[option.name] = value;
    cells = std::move(finer);
  }
  return cells;
}

/// The recipe of a cell, complete except for the hashes of its files.
Recipe cellRecipe(const SheetOptions& options, const Recipe& varied, const OptionTable& table) {
  Recipe given = options.given;
  for (const auto& [name, value] : varied)
    if (table.knows(name)) given[name] = value;
  return completeRecipe(overridden(options.base, given, table), table);
}

/// @param varied  the varied options of the view
CellView parseView(const SheetOptions& options, const Recipe& varied) {
  const OptionTable table(sheetViewOptionSpecs());
  Recipe given = options.view;
  for (const auto& [name, value] : varied) given[name] = value;
  const RecipeReader preview(given, table);
  const bool isMesh =
      preview.has(kPreview) && chosen<bool>(kPreview, preview.text(kPreview), {{"field", false}, {kMesh, true}});
  Recipe base = options.baseView;
  if (isMesh)
    for (const OptionSpec& spec : fieldViewOptionSpecs()) base.erase(spec.name);
  Recipe view = overriddenView(std::move(base), given);
  CellView result{.field = parseFieldPicture(view, table), .mesh = {}};
  if (result.field.render.look.backdrop == Backdrop::None)
    throw std::invalid_argument(
        "--background is none, and the page of a sheet has no alpha; give a colour, or leave it out");
  if (isMesh) {
    std::set<std::string> names;
    for (const auto& [name, value] : given) names.insert(name);
    RequiredEffects effects(table, std::move(names));
    effects.add({completeRecipe(view, table), {}});
    effects.require();
    result.mesh = parseViewOptions(RecipeReader(view, table));
    requireMeshView(*result.mesh);
  } else {
    view.erase(kPreview);  // not an option of pictures of the field
  }
  result.recorded = completeView(std::move(view), OptionTable(pictureOptionSpecs(kCellSize, !isMesh)));
  return result;
}

Plan plan(const SheetOptions& options) {
  requireVaried(options);
  const OptionTable fractal = fractalOptionTable();
  Plan result{.sheet = {}, .cells = {}, .view = parseView(options, {})};
  result.sheet.varied = options.varied;
  result.sheet.view = result.view.recorded;
  for (const VariedOption& option : options.varied)
    if (!fractal.knows(option.name)) result.sheet.view.erase(option.name);
  layOut(options, result.view.width(), result.view.height(), result.sheet);
  FileHashes hashes;
  for (const Recipe& varied : combinations(options.varied)) {
    PlannedCell& planned = result.cells.emplace_back();
    planned.cell.varied = varied;
    Recipe& recipe = planned.cell.recipe;
    recipe = cellRecipe(options, varied, fractal);
    guarded(planned, [&] {
      Recipe ofView = varied;
      std::erase_if(ofView, [&](const auto& entry) { return fractal.knows(entry.first); });
      planned.view = ofView.empty() ? result.view : parseView(options, ofView);
      planned.cell.view = planned.view.recorded;
      std::erase_if(planned.cell.view,
                    [](const auto& entry) { return entry.first == kPreview || !isAppearance(entry.first); });
      for (const auto& [name, hash] : hashes.of(parseFractalOptions(recipe))) recipe[name] = hash;
    });
  }
  return result;
}

/// The file name of a finished cell.
std::string fileNameOf(const PlannedCell& planned) {
  constexpr std::size_t kDigits = 32;  // 128 bits
  const nlohmann::json all{
      {"program", JULIAVDB_VERSION}, {"recipe", planned.cell.recipe}, {"view", planned.view.recorded}};
  return sha256Hex(all.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)).substr(0, kDigits) + ".png";
}

/// "alpha 40"; for a file, only its name without folders.
std::string captionOf(const std::string& option, const std::string& value) {
  const std::size_t slash = value.find(':') == std::string::npos ? value.rfind('/') : std::string::npos;
  return option + " " + (slash == std::string::npos ? value : value.substr(slash + 1));
}

/// The line in a cell's caption about what is finer than its voxels; empty if there is nothing to report.
std::string finerCaption(const Scene& scene) {
  if (!scene.features()) return {};
  const VoxelAdvice advice = adviseVoxels(*scene.features(), scene.voxelSize);
  if (advice.textureShare > kTextureWorthSaying)
    return shortText(std::round(100 * advice.textureShare)) + " % finer than 2 voxels";
  return advice.coreShare > kCoreWorthSaying ? "core thinner than 2 voxels" : "";
}

/// The PNG of a cell, which contains what is finer than the voxels as texts.
std::string fieldPng(const Scene& scene, const FieldPicture& picture, Monitor& monitor) {
  const openvdb::BBoxd region = pictureRegion(scene);
  const FieldImage image =
      renderField(scene.source(), region, pictureOptions(scene, region, picture, FieldColour::Clay), monitor);
  if (std::all_of(image.id.begin(), image.id.end(), [](float id) { return id == 0; }))
    throw DataError("no ray of the picture meets the set: the set is empty, or out of view");
  std::string png = encodeFieldImage(image, "png");
  for (const auto& [key, text] :
       {std::pair(kFiner, finerThanVoxelsText(scene)), std::pair(kFinerCaption, finerCaption(scene))})
    if (!text.empty()) png = withPngText(png, key, text);
  return png;
}

/// Whether this number of meshes like this one may take @a seconds, so that a closer estimate is worthwhile.
bool mayTakeLong(const Scene& scene, double meshes, double seconds) {
  // Seconds that the slowest maps take per node.
  constexpr double kSlowest = 2e-5, kNodesOfBlock = 512;
  return meshes * kNodesOfBlock * static_cast<double>(planScene(scene).blocks->activeVoxelCount()) * kSlowest >=
         seconds;
}

/// The same for pictures of the field.
bool mayTakeLong(const FieldRenderOptions& picture, double pictures, double seconds) {
  // Seconds that only few maps exceed per ray; with short steps there is no bound.
  constexpr double kSlowest = 1e-3;
  if (picture.clarity.alpha) return true;
  return pictures * picture.samples * picture.width * picture.height * kSlowest >= seconds;
}

/// Reports that this number of cells like this one takes long, if it does.
void tellLongWork(const Scene& scene, const CellView& view, std::size_t cells, const LongWork& longWork,
                  Monitor& monitor) {
  if (!longWork.tell) return;
  constexpr double kHour = 3600;
  const double threads = static_cast<double>(tbb::this_task_arena::max_concurrency());
  const double parts = static_cast<double>(cells) / threads;
  const double limit = longWork.seconds * threads;
  double seconds = 0;
  if (view.mesh) {
    if (mayTakeLong(scene, static_cast<double>(cells), limit)) seconds = parts * estimatedMeshSeconds(scene, monitor);
  } else {
    const openvdb::BBoxd region = pictureRegion(scene);
    const FieldRenderOptions picture = pictureOptions(scene, region, view.field, FieldColour::Clay);
    QuietMonitor quiet(monitor);
    if (mayTakeLong(picture, static_cast<double>(cells), limit))
      seconds = parts * FieldRenderer(scene.source(), region).estimatedSeconds(picture, quiet);
  }
  if (seconds == 0 || seconds < longWork.seconds) return;
  longWork.tell((view.mesh ? "the meshes of " : "the pictures of ") + std::to_string(cells) +
                (cells == 1 ? " cell" : " cells") + " will take some " + shortText(seconds / kHour) + " hours " +
                (view.mesh ? "at this resolution, by a small part of the first; a lower --resolution takes less, and "
                             "--preview field does without meshes"
                           : "by a small part of the first; a smaller --size or fewer --samples take less"));
}

/// The finished cells of this sheet and of others.
class CellFolder {
 public:
  explicit CellFolder(const std::filesystem::path& folder) : mFolder(folder) {
    std::error_code ignored;
    if (std::filesystem::exists(folder, ignored) && !std::filesystem::is_directory(folder, ignored))
      throw CreateError("'" + folder.string() + "' is in the way of the folder for finished cells; remove it");
  }

  /// Returns an empty text if there is none.
  std::string find(const std::string& name) const {
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(mFolder / name, ignored)) return {};
    try {
      return readWholeFile(mFolder / name);
    } catch (const std::runtime_error&) {
      return {};  // it is made again
    }
  }

  void add(const std::string& name, const std::string& png) const {
    std::error_code error;
    std::filesystem::create_directories(mFolder, error);
    if (error) throw CreateError("cannot make the folder '" + mFolder.string() + "': " + error.message());
    AtomicFile file(mFolder / name);
    file.stream() << png;
    file.commit();
  }

 private:
  std::filesystem::path mFolder;
};

}  // namespace

std::vector<Recipe> cellRecipes(const SheetOptions& options) {
  const OptionTable table = fractalOptionTable();
  std::vector<Recipe> recipes;
  for (const Recipe& varied : combinations(options.varied)) recipes.push_back(cellRecipe(options, varied, table));
  return recipes;
}

std::vector<OptionSpec> sheetViewOptionSpecs() {
  std::vector<OptionSpec> specs = pictureOptionSpecs(kCellSize, false);
  specs.push_back({.name = kPreview,
                   .argument = "field|mesh",
                   .help = "what a cell shows: the set itself, finer than any voxels, or the mesh that 'fractal' makes "
                           "of the cell",
                   .defaultNote = "field"});
  for (OptionSpec& spec : fieldViewOptionSpecs()) {
    spec.idle = [](const OptionRun& run) {
      return run.text(kPreview) == kMesh ? "it is for pictures of the field, and --preview is mesh; leave it out" : "";
    };
    specs.push_back(std::move(spec));
  }
  return specs;
}

OptionTable variedOptionTable() {
  std::vector<OptionSpec> specs;
  for (const std::string& name : fractalOptionTable().names()) specs.push_back({.name = name});
  for (const OptionSpec& spec : pictureOptionSpecs(kCellSize, true))
    if (isAppearance(spec.name)) specs.push_back({.name = spec.name});
  return OptionTable(std::move(specs));
}

InputFiles inputsOf(const SheetOptions& options) {
  requireVaried(options);
  InputFiles inputs;
  for (const Recipe& recipe : cellRecipes(options)) {
    try {
      inputs.add(inputsOf(parseFractalOptions(recipe)));
    } catch (const std::invalid_argument&) {
      // The cell will show the reason for the failure.
    }
  }
  return inputs;
}

Sheet planSheet(const SheetOptions& options) {
  Plan planned = plan(options);
  for (PlannedCell& cell : planned.cells) planned.sheet.cells.push_back(std::move(cell.cell));
  return std::move(planned.sheet);
}

SheetPage makeSheet(const SheetOptions& options, const std::filesystem::path& folder, Monitor& monitor,
                    const LongWork& longWork) {
  Plan planned = plan(options);
  SheetPage page{.sheet = std::move(planned.sheet)};
  const CellView& view = planned.view;
  const auto makePage = [&](bool saysFiner) {
    return ContactSheet({.rows = page.sheet.rows,
                         .columns = page.sheet.columns,
                         .cellWidth = view.width(),
                         .cellHeight = view.height(),
                         .captionLines = static_cast<int>(options.varied.size()) + (saysFiner ? 1 : 0)});
  };
  // A page that cannot be made is refused before the work begins.
  makePage(!view.mesh);
  ContactSheet single({.cellWidth = view.width(), .cellHeight = view.height()});
  const CellFolder finished(folder);
  SceneMaker scenes;
  std::vector<PlannedCell*> missing;
  for (PlannedCell& cell : planned.cells) {
    // Machines with more or less memory must make the same mesh from the recipe.
    if (view.mesh && !cell.failure && hasAutomaticResolution(cell.cell.recipe))
      guarded(cell, [&] {
        Recipe& recipe = cell.cell.recipe;
        recipe = resolvedRecipe(scenes.make(parseFractalOptions(recipe), monitor), recipe);
      });
    if (cell.failure) continue;
    cell.png = finished.find(fileNameOf(cell));
    if (single.setPicture(0, cell.png)) {
      ++page.reusedCells;
    } else {
      cell.png.clear();
      missing.push_back(&cell);
    }
  }
  bool isTold = false;
  for (PlannedCell* const each : missing) {
    PlannedCell& cell = *each;
    guarded(cell, [&] {
      const auto number = static_cast<std::size_t>(each - planned.cells.data()) + 1;
      NumberedMonitor numbered(monitor, "cell", number, planned.cells.size());
      const FractalOptions fractal = parseFractalOptions(cell.cell.recipe);
      const Scene scene = scenes.make(cell.view.mesh ? fractal : forPictures(fractal), numbered);
      page.metadata.push_back(scene.metadata);
      if (!isTold) tellLongWork(scene, cell.view, missing.size(), longWork, numbered);
      isTold = true;
      const auto& [field, mesh, recorded] = cell.view;
      std::string png = mesh ? encodeImage(meshPicture(scene, *mesh, field.render.look, numbered), "png")
                             : fieldPng(scene, field, numbered);
      monitor.throwIfCancelled();
      finished.add(fileNameOf(cell), png);
      cell.png = std::move(png);
    });
  }
  const auto failed = [](const PlannedCell& cell) { return cell.failure != nullptr; };
  if (std::all_of(planned.cells.begin(), planned.cells.end(), failed))
    std::rethrow_exception(planned.cells.front().failure);

  const auto isFiner = [](const PlannedCell& cell) { return !pngText(cell.png, kFinerCaption).empty(); };
  ContactSheet drawing = makePage(std::any_of(planned.cells.begin(), planned.cells.end(), isFiner));
  for (std::size_t i = 0; i < planned.cells.size(); ++i) {
    PlannedCell& cell = planned.cells[i];
    const int number = static_cast<int>(i) + 1, place = placeOf(page.sheet, static_cast<int>(i));
    if (cell.failure)
      drawing.setMessage(place, cell.cell.error);
    else
      drawing.setPicture(place, cell.png);
    cell.cell.finer = pngText(cell.png, kFiner);
    std::vector<std::string> caption;
    for (const VariedOption& option : page.sheet.varied)
      caption.push_back(captionOf(option.name, cell.cell.varied.at(option.name)));
    if (isFiner(cell)) caption.push_back(pngText(cell.png, kFinerCaption));
    drawing.setCaption(place, number, caption);
    page.sheet.cells.push_back(std::move(cell.cell));
  }
  page.picture = drawing.encode("png");
  return page;
}

}  // namespace vdbtools
