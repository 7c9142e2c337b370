// All kernels, each in a module with the name of its file: what an extension holds.
#pragma once

#include "bilinear.hpp"
#include "binding.hpp"  // first, as Python wants it
#include "color.hpp"
#include "color_filter.hpp"
#include "color_posterior.hpp"
#include "components.hpp"
#include "cuts.hpp"
#include "fourier.hpp"
#include "fourier_ridge.hpp"
#include "fusion.hpp"
#include "ghosts.hpp"
#include "gradients.hpp"
#include "histograms.hpp"
#include "hog.hpp"
#include "illumination.hpp"
#include "localization.hpp"
#include "mixture.hpp"
#include "network_input.hpp"
#include "outlines.hpp"
#include "particles.hpp"
#include "planes.hpp"
#include "preview.hpp"
#include "ring.hpp"
#include "sampling.hpp"
#include "search_window.hpp"
#include "selective_update.hpp"
#include "sobel.hpp"
#include "structure_tensor.hpp"
#include "sway.hpp"

namespace motes::binding {

// clang-format off
template <> struct Reader<sampling::Window>
    : TupleReader<sampling::Window, Index, Index, Index, Index, Index, Index> {};
template <> struct Reader<sampling::Grid> : TupleReader<sampling::Grid, Index, Index> {};
template <> struct Reader<sampling::Reading>
    : TupleReader<sampling::Reading, Plane<const float>, sampling::Grid, int> {};
template <> struct Reader<color::Bins>
    : TupleReader<color::Bins, int, std::uint32_t, std::uint32_t, std::uint32_t> {};
template <> struct Reader<color::Target>
    : TupleReader<color::Target, sampling::Reading, Row<const std::uint32_t>, Floats, color::Bins> {};
template <> struct Reader<particles::Noise>
    : TupleReader<particles::Noise, double, double, double, double, double, Floats, double> {};
template <> struct Reader<color_filter::Likelihood>
    : TupleReader<color_filter::Likelihood, double, double> {};
template <> struct Reader<color_filter::Comparison>
    : TupleReader<color_filter::Comparison, color::Target, color_filter::Likelihood, double,
                  bool> {};
template <> struct Reader<search_window::Place>
    : TupleReader<search_window::Place, double, double, double, double, double> {};
template <> struct Reader<color_posterior::Box>
    : TupleReader<color_posterior::Box, double, double, double, double> {};
template <> struct Reader<ring::Hole> : TupleReader<ring::Hole, Index, Index, Index, Index> {};
template <> struct Reader<illumination::Limits>
    : TupleReader<illumination::Limits, double, double, double, double> {};
template <> struct Reader<localization::PointCues>
    : TupleReader<localization::PointCues, Plane<const float>, double, Plane<const double>, Pair,
                  double, double, Pair> {};
template <> struct Reader<mixture::Learning>
    : TupleReader<mixture::Learning, double, double, double, double, double, double> {};
template <> struct Reader<selective_update::Limits>
    : TupleReader<selective_update::Limits, double, double> {};
// clang-format on

using Keys = Row<const std::uint32_t>;

// Steps of the histograms of color one by one, for tests and benchmarks.
inline Index pixels_within(sampling::Window window, Floats ellipse, sampling::Reading reading,
                           Row<std::uint32_t> offsets, Row<double> weights) {
    return sampling::pixels_within(window, ellipse.data, reading, offsets.data, weights.data);
}
inline void colors_at(Picture picture, Keys offsets, Row<std::uint32_t> colors) {
    sampling::colors_at(picture, offsets.data, offsets.size, colors.data);
}
inline void to_bins(Row<std::uint32_t> colors, color::Bins bins) {
    color::to_bins(colors.data, colors.size, bins);
}
inline void fill(Keys keys, Floats weights, Keys slots, Plane<double> lanes) {
    histograms::fill(keys.data, weights.data, keys.size, slots.data, lanes);
}

inline bool add_kernels(PyObject* extension) {
    return add(extension, "bilinear",
               {unlocked<bilinear::look_up>("look_up"),
                unlocked<bilinear::box_means>("box_means")}) &&
           add(extension, "color",
               {unlocked<color::histograms>("histograms"), unlocked<color::distances>("distances"),
                unlocked<color::mean_shift>("mean_shift"), brief<to_bins>("to_bins")},
               {{"RGB", color::RGB}, {"HSV", color::HSV}, {"HSV_V", color::HSV_V}}) &&
           add(extension, "color_filter",
               {unlocked<color_filter::step>("step"),
                unlocked<color_filter::observe>("observe")}) &&
           add(extension, "color_posterior",
               {unlocked<color_posterior::add_colors>("add_colors"),
                unlocked<color_posterior::color_integral>("color_integral"),
                unlocked<color_posterior::texture>("texture")}) &&
           add(extension, "components",
               {unlocked<components::label>("label"),
                unlocked<components::fill_holes>("fill_holes")}) &&
           add(extension, "cuts", {unlocked<cuts::look>("look")}) &&
           add(extension, "fourier",
               {unlocked<fourier::rfft>("rfft"), unlocked<fourier::rfft2>("rfft2"),
                unlocked<fourier::irfft2>("irfft2")}) &&
           add(extension, "fourier_ridge",
               {unlocked<fourier_ridge::correlate>("correlate"),
                unlocked<fourier_ridge::pad>("pad"), unlocked<fourier_ridge::center>("center"),
                unlocked<fourier_ridge::teach>("teach"), unlocked<fourier_ridge::solve>("solve"),
                unlocked<fourier_ridge::confine>("confine"),
                unlocked<fourier_ridge::alternate>("alternate")}) &&
           add(extension, "fusion", {brief<fusion::log_determinants>("log_determinants")}) &&
           add(extension, "ghosts", {unlocked<ghosts::outline_gradients>("outline_gradients")}) &&
           add(extension, "gradients", {brief<gradients::turns>("turns")}) &&
           add(extension, "histograms",
               {brief<histograms::bhattacharyya>("bhattacharyya"), brief<fill>("fill"),
                brief<histograms::coefficient>("coefficient")},
               {{"LANES", histograms::LANES}}) &&
           add(extension, "hog",
               {unlocked<hog::gradients>("gradients"), unlocked<hog::histograms>("histograms"),
                unlocked<hog::histograms_at>("histograms_at")},
               {{"BAND", hog::BAND}}) &&
           add(extension, "illumination",
               {unlocked<illumination::without_light>("without_light"),
                unlocked<illumination::without_tremble>("without_tremble")}) &&
           add(extension, "localization",
               {unlocked<localization::weigh>("weigh"), unlocked<localization::draw>("draw")}) &&
           add(extension, "mixture",
               {unlocked<mixture::foreground>("foreground"),
                unlocked<mixture::learn_picture>("learn"), unlocked<mixture::means>("means")},
               {{"MODES", mixture::MODES}, {"FIELDS", mixture::FIELDS}, {"PART", mixture::PART}}) &&
           add(extension, "network_input",
               {unlocked<network_input::read_square>("read_square"),
                unlocked<network_input::mean_color>("mean_color")}) &&
           add(extension, "outlines", {brief<outlines::divided>("divided")}) &&
           add(extension, "particles",
               {brief<particles::walk>("walk"), brief<particles::ancestors>("ancestors"),
                brief<particles::gaussian>("gaussian"), brief<particles::normalize>("normalize"),
                brief<particles::combine>("combine"),
                brief<particles::effective_sample_size>("effective_sample_size"),
                brief<particles::appearing>("appearing"), brief<particles::moments>("moments"),
                brief<particles::spread>("spread")}) &&
           add(extension, "planes",
               {unlocked<planes::expose>("expose"), unlocked<planes::relight>("relight"),
                unlocked<planes::green_means>("green_means"),
                brief<planes::mean_difference>("mean_difference"),
                brief<planes::medians>("medians"), brief<planes::median_ratio>("median_ratio"),
                unlocked<planes::window_sums>("window_sums")}) &&
           add(extension, "preview", {unlocked<preview::usual_colors>("usual_colors")},
               {{"MOST", preview::MOST}}) &&
           add(extension, "ring", {unlocked<ring::correlations>("correlations")}) &&
           add(extension, "sampling",
               {brief<pixels_within>("pixels_within"), brief<colors_at>("colors_at"),
                unlocked<sampling::values_within>("values_within"),
                brief<sampling::bounds>("bounds")},
               {{"EPANECHNIKOV", sampling::EPANECHNIKOV},
                {"RADIAL", sampling::RADIAL},
                {"UNIFORM", sampling::UNIFORM},
                {"GAUSSIAN", sampling::GAUSSIAN},
                {"WIDEST", long(sampling::WIDEST)}}) &&
           add(extension, "search_window",
               {unlocked<search_window::cut>("cut"),
                unlocked<search_window::cut_around>("cut_around"),
                unlocked<search_window::cells_of_sizes>("cells_of_sizes"),
                unlocked<search_window::gradient_cells>("gradient_cells")},
               {{"CELL", search_window::CELL}}) &&
           add(extension, "selective_update", {unlocked<selective_update::update>("update")}) &&
           add(extension, "sobel",
               {unlocked<sobel::sobel>("sobel"), unlocked<sobel::histograms>("histograms"),
                unlocked<sobel::histograms_at>("histograms_at")}) &&
           add(extension, "structure_tensor",
               {unlocked<structure_tensor::structure_tensor>("structure_tensor"),
                unlocked<structure_tensor::histograms>("histograms")}) &&
           add(extension, "sway", {unlocked<sway::misfits>("misfits")});
}

// Makes the extension of a name for a set of instructions, with more functions of its own.
inline PyObject* extension(const char* name, const char* instructions, PyMethodDef* functions) {
    static PyModuleDef definition = {};
    definition.m_base = PyModuleDef_HEAD_INIT;
    definition.m_name = name;
    definition.m_size = -1;
    definition.m_methods = functions;
    import_array();
    PyObject* module = PyModule_Create(&definition);
    if (module != nullptr &&
        (PyModule_AddStringConstant(module, "INSTRUCTIONS", instructions) < 0 ||
         !add_kernels(module)))
        Py_CLEAR(module);
    return module;
}

}  // namespace motes::binding
