//! What the reference gives for each stage of a check.

use crate::params::Filter;
use crate::reference::{
    self, BlockStatistics, Channel, Content, Descriptors, Direction, FeatureValues, Images, Messages, Plane, Round,
    Values, Views, Volume,
};
use crate::{ConfidenceMap, DisparityMap, Image, ImageView, Method, Params};

/// What the device made of the pair so far, by operation of a network and side; what is read no more is dropped.
pub(super) type Made = Vec<[Option<Values>; 2]>;

/// What a layer of one side left, or without a layer what the first one reads: the last that was asked for.
pub(super) struct LayerValues {
    pub(super) side: usize,
    pub(super) layer: Option<usize>,
    pub(super) values: FeatureValues,
}

/// The reference's buffers, each computed when a step asks for it.
pub(super) struct Expected {
    /// The rectified pair, until the chain goes on with it.
    pub(super) rectified: Option<[Image; 2]>,
    /// The left view of the mirrored pair, mirrored, if it was matched before.
    pub(super) matched: Option<DisparityMap>,
    /// Where the pair has content, if not everywhere.
    pub(super) content: Option<Content>,
    /// The right view after `validity`.
    pub(super) right: Option<DisparityMap>,
    pub(super) luma: [Plane<u8>; 2],
    pub(super) images: [Images; 2],
    pub(super) prefiltered: [Images; 2],
    /// What the cost compares of both images, halved ever more often.
    pub(super) pyramid: Vec<[Descriptors; 2]>,
    /// Of a network of features.
    pub(super) layer_values: Option<LayerValues>,
    pub(super) rounds: Vec<Round>,
    /// The round to which what follows belongs, and its settings.
    pub(super) level: Option<usize>,
    pub(super) params: Params,
    pub(super) counts: Vec<u32>,
    pub(super) table: Vec<u8>,
    pub(super) penalties: Option<Volume<u8>>,
    pub(super) columns: Volume<u32>,
    pub(super) statistics: Option<[BlockStatistics; 2]>,
    pub(super) cost: Volume<u8>,
    /// The cost of the second pass, while the first one goes on.
    pub(super) second: Option<Volume<u8>>,
    pub(super) paths: Vec<(Direction, Volume<u8>)>,
    /// The data terms and the messages of the levels of belief propagation, the finest first.
    pub(super) coarse: Vec<Volume<u16>>,
    pub(super) messages: Vec<Messages>,
    pub(super) views: Option<Views>,
    /// The pair, which a network reads.
    pub(super) pair: [Image; 2],
    /// What the device made of it by a network, and the disparities.
    pub(super) made: Made,
    pub(super) disparities: Option<Plane<f32>>,
    /// The map of the last stage that left one.
    pub(super) checked: Option<DisparityMap>,
}

impl Expected {
    pub(super) fn new(params: &Params, [left, right]: [ImageView<'_>; 2], content: Option<Content>) -> Self {
        let luma = [left, right].map(|image| reference::gray(image, Channel::Luma));
        let images = [left, right].map(|image| reference::images(image, params));
        let prefiltered = [0, 1].map(|side: usize| images[side].prefiltered(params));
        let mut pyramid = vec![[0, 1].map(|side: usize| prefiltered[side].descriptors(params))];
        let rounds = reference::rounds(left.width(), left.height(), params);
        for _ in 0..rounds[0].halvings {
            pyramid.push(pyramid[pyramid.len() - 1].each_ref().map(reference::halve));
        }
        Self {
            rectified: None,
            matched: None,
            content,
            right: None,
            luma,
            images,
            prefiltered,
            pyramid,
            layer_values: None,
            rounds,
            level: None,
            params: params.clone(),
            counts: Vec::new(),
            table: Vec::new(),
            penalties: None,
            columns: Volume::new(0, 0, 0),
            statistics: None,
            cost: Volume::new(0, 0, 0),
            second: None,
            paths: Vec::new(),
            coarse: Vec::new(),
            messages: Vec::new(),
            views: None,
            pair: [left, right].map(|image| image.to_image()),
            made: Vec::new(),
            disparities: None,
            checked: None,
        }
    }

    /// Goes on with another round.
    pub(super) fn enter(&mut self, level: usize) {
        let before = self.level.replace(level);
        if before == Some(level) {
            return;
        }
        let Round { halvings, params } = self.rounds[level].clone();
        if params.method == Method::Psmnet {
            self.params = params;
            return;
        }
        let [left, right] = &self.pyramid[halvings as usize];
        if params.has_table() {
            let halved = before.map_or(0, |before| self.rounds[before].halvings - halvings);
            self.counts = reference::mi_histogram(left, right, self.checked.as_ref(), halved);
            self.table = reference::mi_table(&self.counts, (left.width * left.height) as u64);
        }
        self.penalties = params.adapts_penalties().then(|| reference::penalties(&self.luma[0], &params));
        self.columns = reference::cost_columns(left, right, &self.table, &params);
        let correlates = params.correlates();
        self.statistics = correlates.then(|| reference::block_statistics(left, right, &params));
        if params.method.quantises() {
            self.cost = reference::matching_cost(&self.columns, &params);
        }
        if params.method == Method::Bp {
            self.coarse = reference::coarse_cost(&self.cost, &params);
            self.messages = reference::messages(&self.cost, &self.coarse, Some(&self.luma[0]), &params);
            self.messages.reverse();
        }
        (self.paths, self.views, self.params) = (Vec::new(), None, params);
        (self.checked, self.right) = (None, None);
    }

    pub(super) fn path(&mut self, direction: Direction) -> &Volume<u8> {
        let known = self.paths.iter().position(|(known, _)| *known == direction);
        let i = known.unwrap_or_else(|| {
            let volume = reference::aggregate_direction(&self.cost, self.penalties.as_ref(), direction, &self.params);
            self.paths.push((direction, volume));
            self.paths.len() - 1
        });
        &self.paths[i].1
    }

    /// The sum of the path costs of all directions.
    fn sum(&mut self) -> Volume<u16> {
        let Volume { width, height, disparities, .. } = self.cost;
        let mut sum = Volume::<u16>::new(width, height, disparities);
        for direction in Direction::all(self.params.paths) {
            for (sum, &path) in sum.data.iter_mut().zip(&self.path(direction).data) {
                *sum += u16::from(path);
            }
        }
        sum
    }

    /// Computes the cost of the second pass, if it is not yet there.
    pub(super) fn second_cost(&mut self) {
        if self.second.is_none() {
            let sum = self.sum();
            self.second = Some(reference::second_cost(&self.cost, &sum, &self.params));
        }
    }

    /// Goes on with the second pass.
    pub(super) fn begin_second_pass(&mut self) {
        if let Some(second) = self.second.take() {
            (self.cost, self.paths) = (second, Vec::new());
        }
    }

    /// The right view that the filters read.
    pub(super) fn right_view(&mut self) -> DisparityMap {
        match (&self.right, &self.matched) {
            (Some(right), _) => right.clone(),
            (None, Some(matched)) if self.level == Some(self.rounds.len() - 1) => matched.clone(),
            _ => self.views().right.clone(),
        }
    }

    /// Where the images of the round have content.
    pub(super) fn content(&self) -> Option<Content> {
        let halvings = self.rounds[self.level?].halvings;
        self.content.as_ref().map(|content| content.halved(halvings))
    }

    /// The map that a filter makes of that of the stage before; `None` if there is none.
    pub(super) fn filtered(&mut self, filter: Filter, params: &Params) -> Option<DisparityMap> {
        let map = self.checked.take()?;
        let right = self.right_view();
        reference::filtered(filter, &map, &right, &self.luma[0], params)
    }

    /// Goes on with the map of a network; a right view is there only by a second match.
    pub(super) fn set_network_views(&mut self, left: DisparityMap) {
        let DisparityMap { width, height, .. } = left;
        let none = vec![0; left.data.len()];
        let right = left.clone();
        let margins = ConfidenceMap { width, height, data: vec![0; left.data.len()] };
        self.checked = Some(left.clone());
        self.views = Some(Views { left, right, margins, labels: none });
    }

    pub(super) fn views(&mut self) -> &Views {
        if self.views.is_none() {
            let params = &self.params.clone();
            let views = match params.method {
                // A network has its own winners, and does not come here.
                Method::Bm | Method::Psmnet => reference::block_match(&self.columns, self.statistics.as_ref(), params),
                Method::Sgm => {
                    let sum = self.sum();
                    self.paths = Vec::new();
                    reference::winner(&sum, params)
                }
                Method::Bp => reference::winner(&reference::beliefs(&self.cost, &self.messages[0]), params),
            };
            self.views = Some(views);
        }
        match &self.views {
            Some(views) => views,
            None => unreachable!("set above"),
        }
    }
}
