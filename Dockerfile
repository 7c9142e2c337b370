# motes in a container, without a compiler and not as root; the current folder is /data:
#
#     docker build -t motes .
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" motes track video.mp4 --init 300,200,40,60 -o track.csv
#
# Extras of pyproject.toml, and motes' other programs, are added by:
#
#     docker build --build-arg PACKAGES='motes[opencv,report,fleet]' -t motes .
ARG PYTHON=3.13

FROM python:${PYTHON}-slim AS build
RUN apt-get update && apt-get install --yes --no-install-recommends g++
WORKDIR /source
COPY . .
RUN python -m pip wheel --no-cache-dir --no-deps --wheel-dir /wheels . ./studio ./fleet ./lab

FROM python:${PYTHON}-slim
ARG PACKAGES=""
RUN --mount=type=bind,from=build,source=/wheels,target=/wheels \
    python -m pip install --no-cache-dir --find-links /wheels /wheels/motes-*.whl $PACKAGES
RUN useradd --create-home motes
USER motes
WORKDIR /data
RUN motes doctor
ENTRYPOINT ["motes"]
CMD ["--help"]
