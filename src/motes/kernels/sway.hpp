// How far a picture is from the background beside its edges, at each shift that it may have.
#pragma once

#include "planes.hpp"

namespace motes::sway {

using Integers = Plane<const std::int32_t>;

// Writes for each shift (x, y) how far the green of a picture is from that of the background, up to
// `most`, at pixels of the background, which are given by their rows, columns and greens.
//
// The picture is first made as bright as the background there, by the median of the ratios.
inline void misfits(Picture picture, Integers pixels, Integers shifts, double most,
                    Plane<double> out) {
    const Index count = pixels.columns;
    Index reach = 0;
    for (const std::int32_t shift : shifts.flat()) reach = std::max(reach, std::abs(Index(shift)));
    fit(pixels.rows == 3 && count > 0 && shifts.columns == 2 && out.rows == shifts.rows &&
            out.columns == count && std::min(picture.height, picture.width) > 2 * reach,
        "rows, columns and greens of pixels, shifts in x and y, and room for all misfits");
    const std::int32_t* usual = pixels[2];
    Scratch<Index> places(count);  // from which all shifts stay in the picture
    for (Index i = 0; i < count; ++i) {
        const Index y = reach + limited(pixels[0][i] - reach, picture.height - 1 - 2 * reach);
        const Index x = reach + limited(pixels[1][i] - reach, picture.width - 1 - 2 * reach);
        places[i] = y * picture.line + x * picture.pixel + picture.green();
    }
    Scratch<double> ratios(count);
    for (Index k = 0; k < shifts.rows; ++k) {
        const Index shift = shifts[k][1] * picture.line + shifts[k][0] * picture.pixel;
        double* __restrict apart = out[k];
        for (Index i = 0; i < count; ++i) {
            apart[i] = picture.data[places[i] + shift];
            ratios[i] = usual[i] / std::max(apart[i], 1.0);
        }
        const double gain = planes::median(ratios.begin(), count);
        for (Index i = 0; i < count; ++i)
            apart[i] = std::min(std::abs(gain * apart[i] - usual[i]), most);
    }
}

}  // namespace motes::sway
