// SPDX-License-Identifier: Apache-2.0
/// @file look_data.h
/// The data of a picture besides its scene: the material, the light, and the colours with their ranges. The program
/// parses the texts of the options and sends the numbers to the page.
#pragma once

#include "vdbtools/render/field_colour.h"
#include "vdbtools/render/look.h"
#include "vdbtools/render/view_options.h"
#include "vdbtools/scene/scene.h"

#include <nlohmann/json.hpp>

namespace vdbtools::explore {

/// The entry "look" of a request: an object of options of vdbtools/render/look.h, all text.
/// @throw std::invalid_argument  it is something else, or has other options
Recipe lookTexts(const nlohmann::json& body);

/// The numbers that such texts stand for: {material, light, sky, ground, background, exposure}. Colours are linear RGB.
/// The background is a colour, "none", or null for the neutral one. @throw std::invalid_argument naming the option
nlohmann::json lookData(const Recipe& texts);

/// The materials by their names: an object of {albedo, gloss, sharpness, mirrors}.
nlohmann::json materialData();

/// The options of a look: {name, help, default}.
nlohmann::json lookOptionData();

/// The names of the gradients.
nlohmann::json gradientData();

/// How a scene is coloured: {by, low, high, stops}. Stops are sRGB, 0 to 1, at equal distances; none for colours
/// without a gradient. For depth also {distance}: the target's distances on a lattice, all in fractal space.
/// @throw as sceneColouring()
nlohmann::json colouringData(const Scene& scene, const ColourChoice& choice, Monitor& monitor);

/// The options of a picture by `juliavdb render --field`, from the entries of a request: view, width, height, samples,
/// look, colour, epsilon, alphaClarity.
/// @throw std::invalid_argument
FieldPicture pictureOf(const nlohmann::json& body);
/// The same as texts of the options of the command line.
Recipe pictureTexts(const nlohmann::json& body);

/// A number, or a list of them, as the text of an option. @throw std::invalid_argument
std::string numberText(const nlohmann::json& value, const std::string& name);

}  // namespace vdbtools::explore
