//! Pictures of how many patches it takes to cover a hologram.

use raylet_plot::chart_panel::Series;
use raylet_plot::figure::{Figure, Panel};
use raylet_plot::panel::FigureError;

use crate::patches::covering::{Covering, RULES};

impl Covering {
    /// What the sensor shows by one patch and by many of each size.
    ///
    /// # Errors
    /// A picture that cannot be drawn.
    pub fn images_png(&self, title: &str) -> Result<Vec<u8>, FigureError> {
        let range = [-0.5 * self.width, 0.5 * self.width];
        let panels: Vec<Panel> = self
            .images
            .iter()
            .map(|(name, image)| {
                let panel = Panel::image(image.view(), range, range).title(name);
                panel.quantity("|U|²", "").into()
            })
            .collect();
        let (whole, rest) = panels.split_at(1);
        let (one, many) = rest.split_at(rest.len() / 2);
        let rows = vec![whole.to_vec(), one.to_vec(), many.to_vec()];
        Figure::new(rows, title).to_png(1.5)
    }

    /// Likeness over positions for each size, positions needed over the size, and what periods cost.
    ///
    /// # Errors
    /// As [`Covering::images_png`].
    pub fn charts_png(&self, title: &str) -> Result<Vec<u8>, FigureError> {
        let mut sides: Vec<f64> = self.curves.iter().map(|curve| curve.side).collect();
        sides.sort_by(f64::total_cmp);
        sides.dedup();
        let over_positions = sides.iter().map(|side| {
            let curves = self.curves.iter().filter(|curve| curve.side == *side);
            let series = curves.map(|curve| {
                let points = curve.points.iter().map(|[count, like, _]| [*count, *like]);
                // The legend of the chart below serves these too, where lines leave no room for it.
                Series::line("", points)
            });
            Panel::lines(series.collect())
                .title(format!("Patches of {side:.0} λ"))
                .x_axis("incident rays", "")
                .y_axis("NCC against the same frame", "")
                .log_x()
                .into()
        });
        let needed = RULES.iter().map(|rule| {
            let of_rule = self.needs.iter().filter(|need| need.rule == rule.name);
            let points = of_rule.filter_map(|need| Some([need.side, need.positions? as f64]));
            Series::line(rule.name, points)
        });
        let needed = Panel::lines(needed.collect())
            .title("Incident rays for NCC 0.99, where it is reached")
            .x_axis("side of the patch", "λ")
            .y_axis("incident rays", "")
            .log_y();
        let errors = self
            .padding
            .iter()
            .map(|[ratio, _, error]| [*ratio, *error]);
        let unlike = self
            .padding
            .iter()
            .map(|[ratio, like, _]| [*ratio, 1.0 - like]);
        let padding = Panel::lines(vec![
            Series::line("relative error of the field", errors),
            Series::line("1 − NCC", unlike),
        ])
        .title("What the copies of a period cost, against free space")
        .x_axis("period over the width of the hologram", "")
        .y_axis("error", "")
        .log_y();
        let rows = vec![
            over_positions.collect(),
            vec![needed.into(), padding.into()],
        ];
        Figure::new(rows, title).to_png(1.5)
    }
}
